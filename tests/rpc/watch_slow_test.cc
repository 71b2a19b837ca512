// Readers of Watch and Subscribe who do not read: over a connection whose windows do not grow, a frame that is larger
// than they are holds up the write of it.

#include <gtest/gtest.h>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "client/cpp/server.h"
#include "tests/support/wait_until.h"
#include "tests/ws/raw_client.h"
#include "tests/ws/running_server.h"

namespace kerf::rpc_test {
namespace {

class SlowWatchTest : public testing::Test {
 protected:
  void SetUp() override {
    app::Config config = ws_test::test_config();
    config.limits.watch_ack_timeout = std::chrono::milliseconds(1000);
    server_ = ws_test::start_server(config);
    ASSERT_NE(server_, nullptr);
    client::Server server(server_->grpc_address());
    ASSERT_TRUE(server.create(client::grid_scene(120, 120, 1.0, 1.0), {"a", true, ""}).ok());
    grpc::ChannelArguments narrow;
    narrow.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    narrow.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    client_ = std::make_unique<client::Client>(
        grpc::CreateCustomChannel(server_->grpc_address(), grpc::InsecureChannelCredentials(), narrow));
  }
  void wait_for_streams(int wanted) {
    const int port = ws_test::port_of(server_->http_url());
    const std::string line = "\nkerf_watch_streams " + std::to_string(wanted) + "\n";
    test::wait_until([&] { return ws_test::request(port, "GET", "/metrics").body.find(line) != std::string::npos; });
  }
  // Checks the stream after the server has released it.
  template <typename Stream>
  void expect_cut_off(Stream& stream) {
    v1::WatchResponse response;
    while (stream.Read(&response)) {
    }
    EXPECT_FALSE(response.has_ended()) << "there was no way to tell";
    EXPECT_EQ(stream.Finish().error_code(), grpc::StatusCode::CANCELLED);
  }

  std::unique_ptr<app::Server> server_;
  std::unique_ptr<client::Client> client_;
};

TEST_F(SlowWatchTest, AViewerThatDoesNotReadIsCutOff) {
  grpc::ClientContext context;
  const auto stalled = client_->stream().Watch(&context);
  v1::WatchRequest start;
  start.mutable_start()->set_name("sheets/a");
  start.mutable_start()->set_encoding(v1::RAW);
  stalled->Write(start);
  wait_for_streams(1);
  wait_for_streams(0);
  expect_cut_off(*stalled);
}

// The write of the first frame is given up 300 ms after the reader counts as too slow.
TEST_F(SlowWatchTest, AViewerThatWakesUpInTimeIsTold) {
  using Clock = std::chrono::steady_clock;
  for (int i = 0; i < 5; ++i) {
    grpc::ClientContext context;
    const auto stalled = client_->stream().Watch(&context);
    v1::WatchRequest start;
    start.mutable_start()->set_name("sheets/a");
    start.mutable_start()->set_encoding(v1::RAW);
    stalled->Write(start);
    wait_for_streams(1);
    const Clock::time_point began = Clock::now();
    while (Clock::now() < began + std::chrono::milliseconds(1100)) std::this_thread::yield();
    v1::WatchResponse response;
    while (stalled->Read(&response)) {
    }
    const bool is_in_time = Clock::now() < began + std::chrono::milliseconds(1250);
    if (!is_in_time) continue;  // a machine that is busy with other things
    EXPECT_EQ(response.ended().reason(), v1::Ended::TOO_SLOW);
    EXPECT_TRUE(stalled->Finish().ok());
    break;
  }
}

TEST_F(SlowWatchTest, ASubscriberThatDoesNotReadIsCutOff) {
  grpc::ClientContext context;
  v1::SubscribeRequest request;
  request.set_name("sheets/a");
  const auto stalled = client_->stream().Subscribe(&context, request);
  wait_for_streams(1);
  wait_for_streams(0);
  expect_cut_off(*stalled);
}

}  // namespace
}  // namespace kerf::rpc_test
