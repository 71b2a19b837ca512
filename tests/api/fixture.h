#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "google/protobuf/empty.pb.h"
#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/interaction.pb.h"
#include "kerf/v1/render.pb.h"
#include "kerf/v1/server.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "server/service/api/api.h"
#include "server/service/api/audit_log.h"
#include "server/service/auth/authenticator.h"
#include "tests/host/fixture.h"

namespace kerf::api {

using host::Answers;
using host::Nanoseconds;
using namespace std::chrono_literals;

// An Api over a host on a clock that the test moves.
class ApiTest : public host::HostTest {
 protected:
  explicit ApiTest(host::HostOptions options = small_host()) : HostTest(std::move(options)) { make_api({}, nullptr); }
  ~ApiTest() override { host_->stop(); }

  static host::HostOptions small_host() {
    host::HostOptions options;
    options.max_sheets = 4;
    options.max_queued_commands = 8;
    options.max_total_vertices = 2'000'000;
    return options;
  }

  void make_api(const Limits& limits, render::Renderer* renderer, KeptStore* store = nullptr) {
    ApiOptions options;
    options.version = "1.2.3";
    options.instance_id = "instance";
    options.limits = limits;
    options.store = store;
    options.authenticator = authenticator_.get();
    options.tenants = tenants_;
    options.audit = audit_.get();
    api_ = std::make_unique<Api>(*host_, renderer, std::move(options), clock_);
  }

  // Answers at once or after some ticks.
  template <typename Request, typename Response, typename... Stop>
  Result<Response> call(void (Api::*method)(const Request&, Reply<Response>, Stop...), const Request& request) {
    Answers<Response> answers;
    ((*api_).*method)(request, answers.callback(), Stop()...);
    host_->wait_idle();
    for (int tick = 0; tick < 200 && answers.count() == 0; ++tick) run_for(kTick);
    EXPECT_EQ(answers.count(), 1U) << "answered once, and in time";
    return answers.at(0);
  }

  template <typename Request, typename Response>
  Result<Response> call(void (Api::*method)(const Request&, const auth::Caller&, Reply<Response>),
                        const Request& request) {
    Answers<Response> answers;
    ((*api_).*method)(request, caller_, answers.callback());
    host_->wait_idle();
    EXPECT_EQ(answers.count(), 1U) << "answered once, and in time";
    return answers.at(0);
  }

  Result<std::string> call_json(const std::string& path, const std::string& json) {
    for (const Method& method : api_->methods()) {
      if (method.path != path) continue;
      Answers<std::string> answers;
      method.call(json, Encoding::kJson, caller_, answers.callback(), {});
      host_->wait_idle();
      for (int tick = 0; tick < 200 && answers.count() == 0; ++tick) run_for(kTick);
      EXPECT_EQ(answers.count(), 1U) << "answered once, and in time";
      return answers.at(0);
    }
    ADD_FAILURE() << "no method " << path;
    return std::string();
  }

  Result<v1::Sheet> create_sheet(const std::string& id, bool paused) {
    v1::CreateSheetRequest request;
    request.set_sheet_id(id);
    request.set_paused(paused);
    v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
    grid.set_columns(7);
    grid.set_rows(7);
    grid.set_width_m(1.0);
    grid.set_height_m(1.0);
    request.mutable_scene()->add_pins()->set_edge(v1::Region::TOP);
    request.mutable_scene()->set_tick_rate_hz(50.0);
    request.mutable_scene()->set_rest_damping(false);  // it swings for as long as a test runs
    return call(&Api::create_sheet, request);
  }

  static v1::CreateCutRequest cut_request(const std::string& parent, double y, const std::string& request_id = {}) {
    v1::CreateCutRequest request;
    request.set_parent(parent);
    request.set_request_id(request_id);
    v1::Polyline& line = *request.mutable_cut()->mutable_curve()->mutable_polyline();
    for (const double x : {-0.1, 1.1}) {
      v1::Vec2& point = *line.add_points();
      point.set_x(x);
      point.set_y(y);
    }
    return request;
  }

  v1::Sheet get_sheet(const std::string& name) {
    v1::GetSheetRequest request;
    request.set_name(name);
    return call(&Api::get_sheet, request).value();
  }

  std::unique_ptr<auth::Authenticator> authenticator_;  // For make_api().
  std::unique_ptr<AuditLog> audit_;                     // For make_api().
  Tenants* tenants_ = nullptr;                          // For make_api().
  auth::Caller caller_ = auth::everybody();
  std::unique_ptr<Api> api_;
};

}  // namespace kerf::api
