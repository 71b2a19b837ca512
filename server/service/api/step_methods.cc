#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "kerf/v1/sheets.pb.h"
#include "server/core/analysis/probe.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/service/api/core.h"
#include "server/service/api/live_probes.h"
#include "server/service/api/sheet_files.h"
#include "server/service/host/step_group.h"

// Implements SheetService.StepSheet and StepSheets.
namespace kerf::api {
namespace {

constexpr int kMaxSteppedSheets = 256;

struct Request {
  std::vector<std::string> names;
  std::vector<std::string> ids;
  std::int64_t ticks = 0;
  bool wants_states = false;
  std::vector<std::int32_t> versions;  // One for each sheet, or none.
  std::vector<scene::Probe> probes;

  [[nodiscard]] bool has_topology(std::size_t number, std::int32_t version) const {
    return !versions.empty() && versions[number] == version;
  }
};

Result<Request> decode(const ApiCore& core, const v1::StepSheetsRequest& message) {
  Request request;
  if (core.stopping) return server_stopping();
  if (message.names_size() < 1 || message.names_size() > kMaxSteppedSheets) {
    return invalid_argument("OUT_OF_RANGE",
                            "names has " + std::to_string(message.names_size()) + " sheets; must have 1 to " +
                                std::to_string(kMaxSteppedSheets),
                            "names");
  }
  std::map<std::string, int> places;
  for (int i = 0; i < message.names_size(); ++i) {
    const std::string field = "names[" + std::to_string(i) + "]";
    KERF_TRY_ASSIGN(std::string id, addressed_sheet(core, message.names(i), field.c_str()));
    const auto [earlier, is_new] = places.try_emplace(id, i);
    if (!is_new) {
      return invalid_argument("NAMED_TWICE",
                              field + " is the same sheet as names[" + std::to_string(earlier->second) + "]", field);
    }
    request.names.push_back(message.names(i));
    request.ids.push_back(std::move(id));
  }
  if (message.topology_versions_size() != 0 && message.topology_versions_size() != message.names_size()) {
    return invalid_argument("OUT_OF_RANGE",
                            "topology_versions has " + std::to_string(message.topology_versions_size()) +
                                " numbers; must have none, or one for each of the " +
                                std::to_string(message.names_size()) + " names",
                            "topology_versions");
  }
  request.versions.assign(message.topology_versions().begin(), message.topology_versions().end());
  request.ticks = message.ticks();
  request.wants_states = message.states();
  KERF_TRY_ASSIGN(request.probes, decode_live_probes(message.probes(), ""));
  return request;
}

// Measures and encodes the sheets of one call. The places of probes are found before the first tick.
class SteppedSheets final : public host::StepVisitor {
 public:
  SteppedSheets(Request request, std::int64_t max_bytes)
      : max_bytes_(max_bytes),
        request_(std::move(request)),
        probes_(request_.ids.size()),
        stepped_(request_.ids.size()) {}

  Status check(std::size_t number, const sheet::Sheet& sheet) override {
    if (request_.wants_states) {
      const std::int64_t vertex_bytes = request_.has_topology(number, sheet.topology_version()) ? 48 : 64;
      bytes_ += vertex_bytes * sheet.mesh().num_vertices() + 16 * std::int64_t{sheet.mesh().num_triangle_slots()};
    }
    if (request_.probes.empty()) return Nothing{};
    KERF_TRY_ASSIGN(analysis::Probes probes, analysis::Probes::create_live(request_.probes, sheet));
    probes_[number] = std::move(probes);
    return Nothing{};
  }

  Status check_all() override {
    if (bytes_ <= max_bytes_) return Nothing{};
    return resource_exhausted("STATES_TOO_LARGE",
                              "the states have " + std::to_string(bytes_) + " bytes; the limit is " +
                                  std::to_string(max_bytes_) + ": step fewer sheets in one call",
                              "states");
  }

  void look(std::size_t number, const sheet::Sheet& sheet, const Status& ended) override {
    v1::SteppedSheet& stepped = stepped_[number];
    stepped.set_name(request_.names[number]);
    stepped.set_tick(sheet.tick());
    stepped.set_topology_version(sheet.topology_version());
    if (!ended.ok()) stepped.set_failure(ended.error().message);
    if (request_.wants_states) {
      const bool with_topology = !request_.has_topology(number, sheet.topology_version());
      *stepped.mutable_state() = encode_exact_state(sheet, with_topology);
      stepped.mutable_state()->set_name(request_.names[number]);
    }
    if (std::optional<analysis::Probes>& probes = probes_[number]) {
      std::vector<double> values;
      probes->measure(sheet, values);
      stepped.mutable_probe_values()->Assign(values.begin(), values.end());
    }
  }

  // Returns the answer once all sheets have been looked at.
  [[nodiscard]] v1::StepSheetsResponse take() {
    v1::StepSheetsResponse response;
    for (v1::SteppedSheet& stepped : stepped_) *response.add_sheets() = std::move(stepped);
    const std::vector<std::string> columns = analysis::Probes::columns_of(request_.probes);
    response.mutable_probe_columns()->Assign(columns.begin(), columns.end());
    return response;
  }
  [[nodiscard]] const Request& request() const { return request_; }

 private:
  const std::int64_t max_bytes_;  // of all states
  const Request request_;
  std::vector<std::optional<analysis::Probes>> probes_;
  std::vector<v1::SteppedSheet> stepped_;
  std::atomic<std::int64_t> bytes_{0};
};

}  // namespace

void Api::step_sheet(const v1::StepSheetRequest& request, Reply<v1::Sheet> reply, std::stop_token stop) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  core_->host.step(*id, request.ticks(), sheet_reply(std::move(reply), "name"), std::move(stop));
}

void Api::step_sheets(const v1::StepSheetsRequest& message, Reply<v1::StepSheetsResponse> reply, std::stop_token stop) {
  Result<Request> request = decode(*core_, message);
  if (!request.ok()) return reply(request.error());
  const auto sheets = std::make_shared<SteppedSheets>(std::move(*request), core_->options.limits.max_stepped_bytes);
  core_->host.step_all(
      sheets->request().ids, sheets->request().ticks, sheets,
      [sheets, reply = std::move(reply)](const Status& done) {
        if (!done.ok()) return reply(done.error());
        reply(sheets->take());
      },
      std::move(stop));
}

}  // namespace kerf::api
