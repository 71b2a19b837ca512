#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "client/cpp/mirror.h"
#include "server/base/random.h"
#include "tests/ws/mirror_check.h"
#include "tests/ws/running_server.h"

namespace kerf::rpc_test {
namespace {

using ws_test::difference;

// A Watch stream, message by message.
class Stream {
 public:
  Stream(client::Client& client, const std::string& name, std::int32_t window = 0) {
    context_.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
    stream_ = client.stream().Watch(&context_);
    v1::WatchRequest request;
    request.mutable_start()->set_name(name);
    request.mutable_start()->set_window(window);
    stream_->Write(request);
  }
  // Nothing at the end.
  std::optional<v1::WatchResponse> read() {
    v1::WatchResponse response;
    if (!stream_->Read(&response)) return std::nullopt;
    return response;
  }
  // Applies the next frame without acknowledging it; nothing if there is none or it does not fit.
  std::optional<v1::Frame> take() {
    const std::optional<v1::WatchResponse> response = read();
    if (!response || !response->has_frame()) return std::nullopt;
    const std::optional<std::string> wrong = mirror.apply(response->frame());
    EXPECT_FALSE(wrong) << *wrong;
    if (wrong) return std::nullopt;
    return response->frame();
  }
  void acknowledge(std::int64_t sequence) {
    v1::WatchRequest request;
    request.mutable_ack()->set_sequence(sequence);
    stream_->Write(request);
  }
  void follow(std::int64_t tick, std::int32_t topology_version) {
    while (mirror.tick() < tick || mirror.topology_version() < topology_version) {
      const std::optional<v1::Frame> frame = take();
      ASSERT_TRUE(frame);
      acknowledge(frame->sequence());
    }
  }
  void cancel() { context_.TryCancel(); }
  void done_writing() { stream_->WritesDone(); }
  grpc::Status finish() { return stream_->Finish(); }

  client::Mirror mirror;

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::WatchRequest, v1::WatchResponse>> stream_;
};

class RpcWatchTest : public ::testing::Test {
 protected:
  void SetUp() override {
    server_ = ws_test::start_server();
    ASSERT_NE(server_, nullptr);
    client_ = std::make_unique<client::Client>(server_->grpc_address());
  }
  void create(const std::string& id, bool paused, double tick_rate_hz = 60.0) {
    v1::CreateSheetRequest request;
    request.set_sheet_id(id);
    request.set_paused(paused);
    request.mutable_scene()->set_tick_rate_hz(tick_rate_hz);
    request.mutable_scene()->add_pins()->set_edge(v1::Region::TOP_CORNERS);
    v1::Integrator& integrator = *request.mutable_scene()->mutable_integrator();
    integrator.set_kind(v1::Integrator::EXPLICIT_LEAPFROG);
    integrator.set_max_substeps(200);  // the motion need not keep up, it only has to be there
    v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
    grid.set_columns(10);
    grid.set_rows(10);
    grid.set_width_m(1.0);
    grid.set_height_m(1.0);
    v1::Sheet sheet;
    const grpc::Status status = client_->call(&v1::SheetService::Stub::CreateSheet, client_->sheets(), request, sheet);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }
  // Along a random curve whose points lie within `reach` of a point of the sheet.
  v1::CutResult cut(const std::string& id, SeededRandom& random, double reach = 0.7) {
    v1::CreateCutRequest request;
    request.set_parent("sheets/" + id);
    v1::CubicBezier& curve = *request.mutable_cut()->mutable_curve()->mutable_bezier();
    const double x = random.uniform(0.0, 1.0);
    const double y = random.uniform(0.0, 1.0);
    for (int i = 0; i < 4; ++i) {
      v1::Vec2& point = *curve.add_points();
      point.set_x(x + random.uniform(-reach, reach));
      point.set_y(y + random.uniform(-reach, reach));
    }
    v1::CutResult result;
    const grpc::Status status = client_->call(&v1::CutService::Stub::CreateCut, client_->cuts(), request, result);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return result;
  }
  v1::Sheet step(const std::string& id, std::int32_t ticks) {
    v1::StepSheetRequest request;
    request.set_name("sheets/" + id);
    request.set_ticks(ticks);
    v1::Sheet sheet;
    const grpc::Status status = client_->call(&v1::SheetService::Stub::StepSheet, client_->sheets(), request, sheet);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return sheet;
  }
  v1::SheetState state(const std::string& id) {
    v1::GetSheetStateRequest request;
    request.set_name("sheets/" + id);
    v1::SheetState state;
    EXPECT_TRUE(client_->call(&v1::SheetService::Stub::GetSheetState, client_->sheets(), request, state).ok());
    return state;
  }
  std::unique_ptr<app::Server> server_;
  std::unique_ptr<client::Client> client_;
};

TEST_F(RpcWatchTest, MirrorEqualsTheServerThroughFiftyCuts) {
  create("a", true);
  Stream stream(*client_, "sheets/a");
  SeededRandom random(3);
  int applied = 0;
  for (int i = 0; i < 200 && applied < 50; ++i) {
    applied += cut("a", random, 0.2).status() == v1::CutResult::APPLIED ? 1 : 0;
    if (i % 3 != 0) step("a", 2);
    const v1::SheetState exact = state("a");
    stream.follow(exact.tick(), exact.topology_version());
    ASSERT_EQ(difference(stream.mirror, exact), "") << "after cut " << i;
  }
  EXPECT_EQ(applied, 50);
}

TEST_F(RpcWatchTest, MirrorEqualsTheServerThroughUndoAndRedo) {
  create("a", true);
  Stream stream(*client_, "sheets/a");
  SeededRandom random(4);
  v1::UndoCutRequest undo;
  v1::RedoCutRequest redo;
  undo.set_parent("sheets/a");
  redo.set_parent("sheets/a");
  int undone = 0;
  int redone = 0;
  for (int i = 0; i < 60; ++i) {
    v1::UndoResult result;
    const std::uint64_t what = random.below(4);
    if (what < 2) cut("a", random, 0.2);
    if (what == 2) undone += client_->call(&v1::CutService::Stub::UndoCut, client_->cuts(), undo, result).ok() ? 1 : 0;
    if (what == 3) redone += client_->call(&v1::CutService::Stub::RedoCut, client_->cuts(), redo, result).ok() ? 1 : 0;
    if (i % 2 == 0) step("a", 2);
    const v1::SheetState exact = state("a");
    stream.follow(exact.tick(), exact.topology_version());
    ASSERT_EQ(difference(stream.mirror, exact), "") << "after step " << i;
  }
  EXPECT_GT(undone, 5);
  EXPECT_GT(redone, 2);
}

TEST_F(RpcWatchTest, ACutShowsInTheFirstFrameOfItsTick) {
  create("a", false, 120.0);
  Stream stream(*client_, "sheets/a");
  SeededRandom random(5);
  stream.follow(2, 0);
  for (int i = 0; i < 5; ++i) {
    const v1::CutResult result = cut("a", random);
    std::optional<v1::Frame> frame;
    while (!frame || frame->tick() < result.tick()) {
      frame = stream.take();
      ASSERT_TRUE(frame);
      stream.acknowledge(frame->sequence());
    }
    EXPECT_GE(stream.mirror.topology_version(), result.topology_version()) << "tick " << frame->tick();
  }
}

TEST_F(RpcWatchTest, ASlowReaderGetsNothingOlderThanItsWindow) {
  create("a", true);
  Stream stream(*client_, "sheets/a", 2);
  ASSERT_TRUE(stream.take());
  EXPECT_EQ(stream.mirror.tick(), 0);
  step("a", 1);
  ASSERT_TRUE(stream.take());
  EXPECT_EQ(stream.mirror.tick(), 1);
  // Two frames are unacknowledged: whatever happens now is not sent.
  SeededRandom random(9);
  for (int i = 0; i < 20; ++i) {
    step("a", 1);
    if (i % 5 == 0) cut("a", random);
  }
  stream.acknowledge(1);
  const std::optional<v1::Frame> third = stream.take();
  ASSERT_TRUE(third);
  EXPECT_EQ(third->sequence(), 3);
  EXPECT_EQ(third->tick(), 21) << "the newest, nothing in between";
  EXPECT_EQ(third->stats().skipped(), 19);
  EXPECT_EQ(difference(stream.mirror, state("a")), "");
}

TEST_F(RpcWatchTest, AStalledReaderHoldsUpNobody) {
  create("a", false, 120.0);
  Stream stalled(*client_, "sheets/a");
  ASSERT_TRUE(stalled.take());
  Stream lively(*client_, "sheets/a");
  lively.follow(40, 0);
  stalled.acknowledge(1);
  const std::optional<v1::Frame> frame = stalled.take();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->sequence(), 2) << "one is under way where nothing says how long it is held";
  EXPECT_GE(frame->tick(), 40);
}

TEST_F(RpcWatchTest, WhatBreaksTheProtocolEndsTheStream) {
  create("a", true);
  Stream unknown(*client_, "sheets/none");
  EXPECT_FALSE(unknown.read());
  const grpc::Status missing = unknown.finish();
  EXPECT_EQ(missing.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(client::failure_of(missing).reason, "SHEET_NOT_FOUND");

  Stream wide(*client_, "sheets/a", 9);
  EXPECT_FALSE(wide.read());
  const grpc::Status window = wide.finish();
  EXPECT_EQ(window.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(client::failure_of(window).field, "start.window");

  Stream hasty(*client_, "sheets/a");
  ASSERT_TRUE(hasty.take());
  hasty.acknowledge(5);
  EXPECT_FALSE(hasty.read());
  EXPECT_EQ(client::failure_of(hasty.finish()).field, "ack.sequence");
}

TEST_F(RpcWatchTest, ClientsMayLeaveAsTheyLike) {
  create("a", false, 240.0);
  const auto tick_now = [this] {
    v1::GetSheetRequest request;
    request.set_name("sheets/a");
    v1::Sheet sheet;
    EXPECT_TRUE(client_->call(&v1::SheetService::Stub::GetSheet, client_->sheets(), request, sheet).ok());
    return sheet.tick();
  };
  for (int i = 0; i < 20; ++i) {
    Stream stream(*client_, "sheets/a");
    if (i % 4 != 0) {
      ASSERT_TRUE(stream.take());
    }
    if (i % 2 == 0) {
      stream.cancel();
      while (stream.read()) {
      }
      EXPECT_EQ(stream.finish().error_code(), grpc::StatusCode::CANCELLED);
    } else {
      stream.done_writing();
      while (stream.read()) {
      }
      EXPECT_TRUE(stream.finish().ok());
    }
  }
  Stream after(*client_, "sheets/a");
  after.follow(tick_now() + 1, 0);
}

TEST_F(RpcWatchTest, DeletionAndStopAreToldBeforeTheEnd) {
  create("a", true);
  create("b", false);
  Stream deleted(*client_, "sheets/a");
  ASSERT_TRUE(deleted.take());
  v1::DeleteSheetRequest request;
  request.set_name("sheets/a");
  google::protobuf::Empty empty;
  ASSERT_TRUE(client_->call(&v1::SheetService::Stub::DeleteSheet, client_->sheets(), request, empty).ok());
  std::optional<v1::WatchResponse> last = deleted.read();
  ASSERT_TRUE(last && last->has_ended());
  EXPECT_EQ(last->ended().reason(), v1::Ended::SHEET_DELETED);
  EXPECT_FALSE(deleted.read());
  EXPECT_TRUE(deleted.finish().ok());

  std::vector<std::unique_ptr<Stream>> open;
  for (int i = 0; i < 5; ++i) {
    open.push_back(std::make_unique<Stream>(*client_, "sheets/b"));
    ASSERT_TRUE(open.back()->take());
  }
  std::thread stop([this] { server_->stop(); });
  for (const std::unique_ptr<Stream>& stream : open) {
    last = stream->read();
    while (last && last->has_frame()) last = stream->read();
    EXPECT_TRUE(last && last->ended().reason() == v1::Ended::SERVER_STOPPING);
    EXPECT_FALSE(stream->read());
    EXPECT_TRUE(stream->finish().ok());
  }
  stop.join();
}

TEST_F(RpcWatchTest, SubscriptionIsReadableWithoutAcknowledging) {
  create("a", false);
  grpc::ClientContext context;
  v1::SubscribeRequest request;
  request.set_name("sheets/a");
  request.set_max_rate_hz(10.0);
  request.set_max_frames(3);
  const auto stream = client_->stream().Subscribe(&context, request);
  client::Mirror mirror;
  v1::WatchResponse response;
  int frames = 0;
  while (stream->Read(&response)) {
    ASSERT_EQ(mirror.apply(response.frame()), std::nullopt);
    ++frames;
  }
  EXPECT_EQ(frames, 3);
  EXPECT_TRUE(stream->Finish().ok());

  grpc::ClientContext refused;
  request.set_name("sheets/nowhere");
  const auto none = client_->stream().Subscribe(&refused, request);
  EXPECT_FALSE(none->Read(&response));
  const grpc::Status status = none->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(client::failure_of(status).field, "name");
}

}  // namespace
}  // namespace kerf::rpc_test
