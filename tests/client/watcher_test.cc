// Streams of a whole kerfd that give a slow reader up, and those without acknowledgements.

#include "client/cpp/watcher.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>
#include <gtest/gtest.h>

#include "client/cpp/server.h"
#include "tests/support/closed_port.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"
#include "tests/ws/raw_client.h"
#include "tests/ws/running_server.h"

namespace kerf::client {
namespace {

class WatcherTest : public testing::Test {
 protected:
  void SetUp() override {
    app::Config config = ws_test::test_config();
    config.limits.watch_ack_timeout = std::chrono::milliseconds(100);
    running_ = ws_test::start_server(config);
    ASSERT_NE(running_, nullptr);
    server_ = std::make_unique<Server>(running_->grpc_address());
    ASSERT_TRUE(server_->create(grid_scene(8, 8, 1.0, 1.0), {"a", true, ""}).ok());
  }
  Sheet sheet() { return server_->sheet("a"); }
  // Until the server has given every stream up.
  void dawdle() {
    const int port = ws_test::port_of(running_->http_url());
    test::wait_until([&] {
      return ws_test::request(port, "GET", "/metrics").body.find("\nkerf_watch_streams 0\n") != std::string::npos;
    });
  }

  std::unique_ptr<app::Server> running_;
  std::unique_ptr<Server> server_;
};

TEST_F(WatcherTest, AStreamThatWasGivenUpIsOpenedAgain) {
  Watcher watcher(server_->client());
  watcher.set_pace(1000.0);
  std::vector<std::int64_t> ticks;
  std::vector<std::int64_t> sequences;
  WatchOptions options;
  options.window = 1;  // nothing more is on its way when a stream is given up
  const grpc::Status status = watcher.run("sheets/a", options, [&](const v1::Frame& frame, const Mirror& mirror) {
    EXPECT_EQ(mirror.num_vertices(), 64);
    ticks.push_back(frame.tick());
    sequences.push_back(frame.sequence());
    if (ticks.size() == 3) return false;
    EXPECT_TRUE(sheet().step(1).ok());
    dawdle();
    return true;
  });
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(ticks, (std::vector<std::int64_t>{0, 1, 2})) << "the newest each";
  EXPECT_EQ(sequences, (std::vector<std::int64_t>{1, 1, 1})) << "a stream each";
  EXPECT_EQ(watcher.ended().reason(), v1::Ended::REASON_UNSPECIFIED);
}

TEST_F(WatcherTest, FramesHaveTheValuesOfProbes) {
  WatchOptions options;
  v1::Probe& probe = options.probes.emplace_back();
  probe.set_name("corner");
  probe.set_quantity(v1::Probe::POSITION);
  probe.add_points();
  Watcher watcher(server_->client());
  std::vector<std::int64_t> ticks;
  const grpc::Status status = watcher.run("sheets/a", options, [&](const v1::Frame& /*frame*/, const Mirror& mirror) {
    ticks.push_back(mirror.tick());
    EXPECT_EQ(mirror.probe_columns(), (std::vector<std::string>{"corner.x", "corner.y", "corner.z"}));
    EXPECT_EQ(mirror.probe_values().at(2), sheet().state().value().positions.at(2));
    return ticks.size() < 3 && sheet().step(1).ok();
  });
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(ticks, (std::vector<std::int64_t>{0, 1, 2}));
}

// Frames in transit fill the connection, so that the server cannot even send the reason for ending the stream.
TEST_F(WatcherTest, OneThatCouldNotBeWrittenToIsOpenedAgainToo) {
  ASSERT_TRUE(server_->create(grid_scene(150, 150, 1.0, 1.0), {"large", false, ""}).ok());
  WatchOptions options;
  options.window = 8;
  options.encoding = v1::RAW;
  int keyframes = 0;
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);  // no more than 64 KiB under way: less than a frame
  Client client(grpc::CreateCustomChannel(running_->grpc_address(), grpc::InsecureChannelCredentials(), arguments));
  Watcher watcher(client);
  const grpc::Status status =
      watcher.run("sheets/large", options, [&](const v1::Frame& frame, const Mirror& /*mirror*/) {
        if (frame.base_tick() >= 0) return true;
        if (++keyframes == 3) return false;
        dawdle();
        return true;
      });
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(keyframes, 3);
}

// A server, and one that takes its place at the same address with the same scene.
class RestartTest : public testing::Test {
 protected:
  void SetUp() override {
    config_.scenes = {folder_.write("a.json", R"({"grid": {"columns": 8, "rows": 8, "width_m": 1, "height_m": 1}})")};
    config_.grpc.port = port_.number();
    running_ = ws_test::start_server(config_);
    ASSERT_NE(running_, nullptr);
    client_ = std::make_unique<Client>(running_->grpc_address());
  }
  void restart() {
    running_.reset();
    running_ = ws_test::start_server(config_);
  }

  const test::TemporaryFolder folder_;
  const test::ClosedPort port_;
  app::Config config_ = ws_test::test_config();
  std::unique_ptr<app::Server> running_;
  std::unique_ptr<Client> client_;
};

TEST_F(RestartTest, AStreamGoesOnWithTheServerThatIsStartedAgain) {
  Watcher watcher(*client_);
  WatchOptions options;
  options.reopening.when_lost = std::chrono::seconds(60);
  std::vector<std::int64_t> sequences;
  const grpc::Status status = watcher.run("sheets/a", options, [&](const v1::Frame& frame, const Mirror& mirror) {
    EXPECT_EQ(mirror.num_vertices(), 64);
    if (frame.base_tick() >= 0) return true;  // of the same server
    sequences.push_back(frame.sequence());
    if (sequences.size() == 3) return false;
    restart();
    return true;
  });
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(sequences, (std::vector<std::int64_t>{1, 1, 1})) << "a stream of each server";
}

TEST_F(RestartTest, CallsFindAServerThatIsBackWithinTwoSeconds) {
  const auto answers = [&] {
    v1::ServerInfo info;
    return client_->call(&v1::ServerService::Stub::GetServerInfo, client_->server(), v1::GetServerInfoRequest(), info)
        .ok();
  };
  ASSERT_TRUE(answers());
  running_.reset();
  // gRPC's waits between tries have grown to their longest by then. A call without a server takes 0.1 s.
  for (int i = 0; i < 30; ++i) ASSERT_FALSE(answers());
  running_ = ws_test::start_server(config_);
  int tries = 0;
  while (!answers()) ASSERT_LT(++tries, 20);
}

TEST_F(RestartTest, AndEndsWhereItIsNotToBeWaitedFor) {
  Watcher watcher(*client_);
  int frames = 0;
  const grpc::Status status = watcher.run("sheets/a", {}, [&](const v1::Frame& /*frame*/, const Mirror& /*mirror*/) {
    if (++frames == 1) running_.reset();
    return true;
  });
  EXPECT_TRUE(!status.ok() || watcher.ended().reason() == v1::Ended::SERVER_STOPPING);
}

TEST_F(RestartTest, ItIsGivenUpWhenItsTimeIsOverOrItIsStopped) {
  running_.reset();
  const auto none = [](const v1::Frame& /*frame*/, const Mirror& /*mirror*/) { return false; };
  WatchOptions options;
  options.reopening.when_lost = std::chrono::milliseconds(1);
  EXPECT_EQ(Watcher(*client_).run("sheets/a", options, none).error_code(), grpc::StatusCode::UNAVAILABLE);
  options.reopening.when_lost = std::chrono::hours(1);
  Watcher watcher(*client_);
  std::thread stopper([&watcher] { watcher.stop(); });
  EXPECT_TRUE(watcher.run("sheets/a", options, none).ok());
  stopper.join();
}

TEST_F(WatcherTest, OrNotWhereThatIsWanted) {
  WatchOptions options;
  options.reopening.when_slow = false;
  int frames = 0;
  const Result<v1::Ended> ended = sheet().watch(
      [&](const v1::Frame& /*frame*/, const Mirror& /*mirror*/) {
        ++frames;
        dawdle();
        return true;
      },
      options);
  EXPECT_EQ(ended.value().reason(), v1::Ended::TOO_SLOW);
  EXPECT_EQ(frames, 1);
}

TEST_F(WatcherTest, StoppedBeforeItBeginsItSeesNothing) {
  Watcher watcher(server_->client());
  watcher.stop();
  const grpc::Status status = watcher.run("sheets/a", {}, [](const v1::Frame& /*frame*/, const Mirror& /*mirror*/) {
    ADD_FAILURE() << "a frame";
    return false;
  });
  EXPECT_TRUE(status.ok());
}

TEST_F(WatcherTest, StoppedTwiceItHoldsNothingOfTheRunBetween) {
  Watcher watcher(server_->client());
  const auto none = [](const v1::Frame& /*frame*/, const Mirror& /*mirror*/) { return false; };
  watcher.stop();
  EXPECT_TRUE(watcher.run("sheets/a", {}, none).ok());
  watcher.stop();  // of a call that is over and gone
}

TEST_F(WatcherTest, WhatOnFrameThrowsComesOutAndNothingIsHeld) {
  Watcher watcher(server_->client());
  const auto fail = [](const v1::Frame& /*frame*/, const Mirror& /*mirror*/) -> bool {
    throw std::runtime_error("no");
  };
  EXPECT_THROW(static_cast<void>(watcher.run("sheets/a", {}, fail)), std::runtime_error);
  watcher.set_pace(5.0);
  watcher.stop();
}

TEST_F(WatcherTest, ASubscriptionNeedsNoAcknowledgements) {
  ASSERT_TRUE(sheet().resume().ok());
  SubscribeOptions options;
  options.rate_hz = 10.0;
  options.max_frames = 4;
  std::vector<std::int64_t> ticks;
  const auto log = [&](const v1::Frame& frame, const Mirror& mirror) {
    EXPECT_EQ(mirror.num_vertices(), 64);
    ticks.push_back(frame.tick());
    return true;
  };
  EXPECT_EQ(sheet().subscribe(log, options).value().reason(), v1::Ended::REASON_UNSPECIFIED) << "it had its frames";
  ASSERT_EQ(ticks.size(), 4U);
  EXPECT_GE(ticks[3] - ticks[0], 4) << "at 50 a second";

  int frames = 0;
  const auto first = [&](const v1::Frame& /*frame*/, const Mirror& /*mirror*/) { return ++frames < 1; };
  EXPECT_TRUE(sheet().subscribe(first).ok());
  EXPECT_EQ(frames, 1);
  options.rate_hz = 50.0;
  EXPECT_EQ(sheet().subscribe(log, options).failure().field, "max_rate_hz");
  EXPECT_EQ(server_->sheet("none").subscribe(log).failure().code, grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace kerf::client
