#include "server/service/local/local_server.h"

#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/render.pb.h"
#include "kerf/v1/server.pb.h"
#include "kerf/v1/sheets.pb.h"

namespace kerf::local {
namespace {

constexpr const char* kStep = "/kerf.v1.SheetService/StepSheet";
constexpr const char* kCreate = "/kerf.v1.SheetService/CreateSheet";

class LocalServerTest : public testing::Test {
 protected:
  template <typename Response>
  Result<Response> call(const char* path, const google::protobuf::Message& request) {
    std::optional<Result<std::string>> answer = server_->call(path, request.SerializeAsString(), std::nullopt);
    if (!answer->ok()) return answer->error();
    Response response;
    EXPECT_TRUE(response.ParseFromString(answer->value()));
    return response;
  }
  Result<v1::Sheet> create(const std::string& id, int columns = 4) {
    v1::CreateSheetRequest request;
    request.set_sheet_id(id);
    request.set_paused(true);
    v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
    grid.set_columns(columns);
    grid.set_rows(columns);
    grid.set_width_m(1.0);
    grid.set_height_m(1.0);
    return call<v1::Sheet>(kCreate, request);
  }
  static v1::StepSheetRequest steps(const std::string& id, int ticks) {
    v1::StepSheetRequest request;
    request.set_name("sheets/" + id);
    request.set_ticks(ticks);
    return request;
  }

  std::unique_ptr<LocalServer> server_ = LocalServer::start({.workers = 2}).value();
};

TEST_F(LocalServerTest, SheetsAreMadeSteppedAndCut) {
  ASSERT_TRUE(create("a").ok());
  EXPECT_EQ(call<v1::Sheet>(kStep, steps("a", 3))->tick(), 3);
  v1::CreateCutRequest cut;
  cut.set_parent("sheets/a");
  v1::Polyline& line = *cut.mutable_cut()->mutable_curve()->mutable_polyline();
  for (const double x : {-0.1, 1.1}) {
    v1::Vec2& point = *line.add_points();
    point.set_x(x);
    point.set_y(0.45);
  }
  const Result<v1::CutResult> result = call<v1::CutResult>("/kerf.v1.CutService/CreateCut", cut);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->pieces(), 2);
}

TEST_F(LocalServerTest, TwoServersShareNothing) {
  const std::unique_ptr<LocalServer> other = LocalServer::start({}).value();
  ASSERT_TRUE(create("a").ok());
  const auto answer = other->call(kStep, steps("a", 1).SerializeAsString(), std::nullopt);
  EXPECT_EQ(answer->error().reason, "SHEET_NOT_FOUND");
}

TEST_F(LocalServerTest, RefusalsSayWhatIsWrong) {
  EXPECT_EQ(server_->call("/kerf.v1.StreamService/Watch", "", std::nullopt)->error().reason, "NO_SUCH_CALL");
  EXPECT_EQ(server_->call(kStep, "\xff", std::nullopt)->error().reason, "MALFORMED_MESSAGE");
  EXPECT_EQ(call<v1::Sheet>(kStep, steps("gone", 1)).error().reason, "SHEET_NOT_FOUND");
  EXPECT_EQ(server_->upload_sheet("\xff", "", std::nullopt)->error().reason, "MALFORMED_MESSAGE");
  EXPECT_EQ(LocalServer::start({.workers = 257}).error().reason, "BAD_WORKERS");
  EXPECT_EQ(LocalServer::start({.workers = -1}).error().reason, "BAD_WORKERS");
  EXPECT_TRUE(LocalServer::start({.workers = 256}).ok());
}

TEST_F(LocalServerTest, AStepWhoseTimeIsOverEndsAfterItsTick) {
  ASSERT_TRUE(create("a", 40).ok());
  EXPECT_FALSE(server_->call(kStep, steps("a", 100'000).SerializeAsString(), std::chrono::nanoseconds(1)).has_value());
  Result<v1::Sheet> next = call<v1::Sheet>(kStep, steps("a", 1));
  while (!next.ok()) {
    ASSERT_EQ(next.error().reason, "STEPPING") << next.error().message;
    next = call<v1::Sheet>(kStep, steps("a", 1));
  }
  EXPECT_LT(next->tick(), 100'000);
}

TEST_F(LocalServerTest, AMeshOfAnySizeIsUploaded) {
  v1::SheetUpload start;
  start.mutable_sheet()->set_sheet_id("mesh");
  start.mutable_sheet()->mutable_scene()->mutable_obj();
  const std::string mesh = std::string(2U << 20U, '\n') + "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  start.set_num_bytes(static_cast<std::int64_t>(mesh.size()));
  v1::Sheet sheet;
  const auto made = server_->upload_sheet(start.SerializeAsString(), mesh, std::nullopt);
  ASSERT_TRUE(made->ok()) << made->error().message;
  ASSERT_TRUE(sheet.ParseFromString(made->value()));
  EXPECT_EQ(sheet.num_vertices(), 4);
  const auto longer = server_->upload_sheet(start.SerializeAsString(), mesh + " ", std::nullopt);
  EXPECT_EQ(longer->error().reason, "UPLOAD_LENGTH");
}

TEST_F(LocalServerTest, DrawsPicturesIfAsked) {
  v1::RenderImageRequest picture;
  picture.set_name("sheets/a");
  ASSERT_TRUE(create("a").ok());
  EXPECT_EQ(call<v1::RenderImageResponse>("/kerf.v1.RenderService/RenderImage", picture).error().reason,
            "RENDERER_UNAVAILABLE");
  server_ = LocalServer::start({.workers = 1, .render = true}).value();
  const auto info = call<v1::ServerInfo>("/kerf.v1.ServerService/GetServerInfo", v1::GetServerInfoRequest());
  if (info->renderer().starts_with("none")) GTEST_SKIP() << info->renderer();
  ASSERT_TRUE(create("a").ok());
  EXPECT_FALSE(call<v1::RenderImageResponse>("/kerf.v1.RenderService/RenderImage", picture)->image().empty());
}

TEST_F(LocalServerTest, ThreadsCallItSideBySide) {
  std::vector<std::thread> threads;
  for (const char* id : {"a", "b", "c", "d"}) {
    threads.emplace_back([this, id] {
      EXPECT_TRUE(create(id).ok());
      for (int tick = 1; tick <= 20; ++tick) EXPECT_EQ(call<v1::Sheet>(kStep, steps(id, 1))->tick(), tick);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace kerf::local
