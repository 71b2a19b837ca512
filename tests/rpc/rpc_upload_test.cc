// Uploads that stand still, on a clock that the test moves.

#include "server/rpc/patience.h"

#include <chrono>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "kerf/v1/sheets.grpc.pb.h"
#include "server/rpc/rpc_server.h"
#include "tests/api/api_fixture.h"

namespace kerf::rpc_test {
namespace {

using namespace std::chrono_literals;
using rpc::Patience;

class PatienceTest : public testing::Test {
 protected:
  host::ManualClock clock_;
  int given_up_ = 0;
  std::shared_ptr<Patience> patience_ = std::make_shared<Patience>(clock_, 30s);
};

TEST_F(PatienceTest, EndsOnceWhenNothingComes) {
  patience_->begin([this] { ++given_up_; });
  clock_.move_to(29s);
  EXPECT_EQ(given_up_, 0);
  clock_.move_to(30s);
  EXPECT_EQ(given_up_, 1);
  EXPECT_FALSE(patience_->arrived());
  EXPECT_FALSE(patience_->end());
  clock_.move_to(300s);
  EXPECT_EQ(given_up_, 1);
  EXPECT_EQ(clock_.num_timers(), 0U);
}

TEST_F(PatienceTest, CountsAnewFromWhatComes) {
  patience_->begin([this] { ++given_up_; });
  for (int i = 1; i <= 20; ++i) {
    clock_.move_to(i * 20s);
    ASSERT_TRUE(patience_->arrived());
    ASSERT_LE(clock_.num_timers(), 1U);
  }
  clock_.move_to(429s);
  EXPECT_EQ(given_up_, 0);
  clock_.move_to(430s);
  EXPECT_EQ(given_up_, 1);
}

TEST_F(PatienceTest, AnEndedCallIsLeftAlone) {
  patience_->begin([this] { ++given_up_; });
  EXPECT_TRUE(patience_->end());
  EXPECT_FALSE(patience_->end());
  EXPECT_EQ(clock_.num_timers(), 0U);
  patience_.reset();
  clock_.move_to(60s);
  EXPECT_EQ(given_up_, 0);
}

class UploadTest : public api::ApiTest {
 protected:
  UploadTest() {
    rpc::RpcOptions options;
    options.upload_timeout = 30s;
    server_ = std::make_unique<rpc::RpcServer>(*api_, clock_, options);
    client_ = std::make_unique<client::Client>("127.0.0.1:" + std::to_string(server_->start("127.0.0.1:0").value()));
  }

  // Until the server waits for something that is sent to it.
  void wait_for_timer() const {
    while (clock_.num_timers() == 0) std::this_thread::yield();
  }
  // As the client is told of a call that it goes on with for ever.
  template <typename Writer>
  client::Failure after_30_s(Writer& writer) {
    wait_for_timer();
    clock_.move_to(clock_.now() + 30s);
    const grpc::Status status = writer.Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED) << status.error_message();
    return client::failure_of(status);
  }

  std::unique_ptr<rpc::RpcServer> server_;
  std::unique_ptr<client::Client> client_;
};

TEST_F(UploadTest, OneThatStandsStillIsEnded) {
  grpc::ClientContext context;
  v1::Sheet sheet;
  const auto writer = client_->sheets().UploadSheet(&context, &sheet);
  v1::UploadSheetRequest start;
  start.mutable_start()->mutable_sheet()->mutable_scene()->mutable_obj();
  start.mutable_start()->set_num_bytes(1000);
  writer->Write(start);
  const client::Failure failure = after_30_s(*writer);
  EXPECT_EQ(failure.reason, "UPLOAD_STALLED");
  EXPECT_NE(failure.message.find("for 30 s"), std::string::npos) << failure.message;
}

TEST_F(UploadTest, SoIsOneThatNeverBegins) {
  grpc::ClientContext context;
  v1::Sheet sheet;
  const auto writer = client_->sheets().ReplayRecording(&context, &sheet);
  EXPECT_EQ(after_30_s(*writer).reason, "UPLOAD_STALLED");
}

TEST_F(UploadTest, WhatIsSentWholeKeepsNoTimer) {
  grpc::ClientContext context;
  v1::Sheet sheet;
  const auto writer = client_->sheets().UploadSheet(&context, &sheet);
  v1::UploadSheetRequest start, chunk;
  start.mutable_start()->mutable_sheet()->mutable_scene()->mutable_obj()->set_rest_shape(v1::REST_SHAPE_FLAT);
  start.mutable_start()->mutable_sheet()->set_paused(true);
  chunk.set_chunk("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  start.mutable_start()->set_num_bytes(static_cast<std::int64_t>(chunk.chunk().size()));
  writer->Write(start);
  wait_for_timer();
  clock_.move_to(clock_.now() + 29s);
  writer->Write(chunk);
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(sheet.num_vertices(), 3);
  EXPECT_EQ(clock_.num_timers(), 0U);
}

}  // namespace
}  // namespace kerf::rpc_test
