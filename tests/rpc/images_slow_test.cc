// Tests readers of WatchImages that stall, and requests that no reader should send: their cost, borne by no other
// reader.

#include <gtest/gtest.h>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <memory>
#include <string>
#include <vector>

#include "client/cpp/failure.h"
#include "tests/rpc/images_fixture.h"
#include "tests/support/wait_until.h"
#include "tests/ws/raw_client.h"

namespace kerf::rpc_test {
namespace {

using grpc::StatusCode;

constexpr int kTicks = 20;

class SlowImagesTest : public ImagesTest {
 protected:
  SlowImagesTest() { config_.limits.watch_ack_timeout = std::chrono::milliseconds(300); }

  // With a reader of MJPEG, who owes no acknowledgements: that it is served depends on no time.
  void SetUp() override {
    ImagesTest::SetUp();
    if (IsSkipped()) return;
    http_port_ = ws_test::port_of(server_->http_url());
    lively_ = std::make_unique<ws_test::RawClient>(http_port_);
    lively_->send("GET /sheets/a.mjpeg?width=64&height=48 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    ASSERT_TRUE(next_part() && next_part()) << "the head and the first picture";
  }
  double metric(const std::string& name) const {
    const std::string page = ws_test::request(http_port_, "GET", "/metrics").body;
    const std::size_t found = page.find("\n" + name + " ");
    return found == std::string::npos ? -1.0 : std::stod(page.substr(found + name.size() + 2));
  }
  // Steps the sheet, and reads each tick's picture.
  void follow() {
    for (int tick = 0; tick < kTicks; ++tick) {
      step();
      ASSERT_TRUE(next_part()) << tick;
    }
  }
  void wait_for_one_stream() {
    test::wait_until([&] { return metric("kerf_image_streams") == 1.0; });
  }
  // For others than the lively reader.
  double rendered() const { return metric("kerf_pictures_rendered_total") - (1.0 + kTicks); }

 private:
  bool next_part() { return lively_->read_until("\r\n--kerf-picture\r\n").has_value(); }

  int http_port_ = 0;
  std::unique_ptr<ws_test::RawClient> lively_;
};

TEST_F(SlowImagesTest, AReaderThatDoesNotAcknowledgeIsTold) {
  grpc::ClientContext context;
  const auto stalled = open(context);
  v1::WatchImagesRequest start = start_of(v1::IMAGE_JPEG);
  start.mutable_start()->set_window(2);
  stalled->Write(start);
  follow();
  int pictures = 0;
  v1::WatchImagesResponse response;
  while (stalled->Read(&response) && response.has_image()) ++pictures;
  EXPECT_EQ(response.ended().reason(), v1::Ended::TOO_SLOW);
  EXPECT_FALSE(stalled->Read(&response));
  EXPECT_TRUE(stalled->Finish().ok());
  EXPECT_GE(pictures, 1);
  EXPECT_LE(pictures, 2) << "its window";
  wait_for_one_stream();
  EXPECT_LE(rendered(), 2.0);
}

// Over a connection whose windows do not grow, so that a picture that is larger than they are holds up the write of it.
TEST_F(SlowImagesTest, AReaderThatDoesNotEvenReadIsCutOff) {
  grpc::ChannelArguments narrow;
  narrow.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  narrow.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  client::Client client(grpc::CreateCustomChannel(server_->grpc_address(), grpc::InsecureChannelCredentials(), narrow));
  grpc::ClientContext context;
  const auto stalled = client.render().WatchImages(&context);
  v1::WatchImagesRequest start = start_of(v1::IMAGE_PNG);
  start.mutable_start()->mutable_view()->set_width_px(1600);
  start.mutable_start()->mutable_view()->set_height_px(1200);
  stalled->Write(start);
  follow();
  test::wait_until([&] { return rendered() >= 1.0; });
  wait_for_one_stream();
  EXPECT_LE(rendered(), 2.0) << "as many as its window has";
  v1::WatchImagesResponse response;
  while (stalled->Read(&response)) {
  }
  EXPECT_FALSE(response.has_ended()) << "there was no way to tell";
  EXPECT_EQ(stalled->Finish().error_code(), StatusCode::CANCELLED);
}

TEST_F(ImagesTest, WhatIsNoProtocolIsRefusedWithItsStatus) {
  const auto refused = [this](const std::vector<v1::WatchImagesRequest>& requests) {
    grpc::ClientContext context;
    const auto stream = open(context);
    for (const v1::WatchImagesRequest& request : requests) stream->Write(request);
    v1::WatchImagesResponse response;
    while (stream->Read(&response)) {
    }
    return stream->Finish();
  };
  v1::WatchImagesRequest ack;
  ack.mutable_ack()->set_sequence(7);
  EXPECT_EQ(refused({ack}).error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(refused({v1::WatchImagesRequest()}).error_code(), StatusCode::INVALID_ARGUMENT);
  const v1::WatchImagesRequest start = start_of(v1::IMAGE_JPEG);
  EXPECT_EQ(refused({start, ack}).error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(refused({start, start}).error_code(), StatusCode::INVALID_ARGUMENT);
  v1::WatchImagesRequest nobody = start;
  nobody.mutable_start()->set_name("sheets/nobody");
  EXPECT_EQ(refused({nobody}).error_code(), StatusCode::NOT_FOUND);
}

TEST_F(ImagesTest, AMessageBeyondTheLimitEndsOnlyItsOwnStream) {
  grpc::ClientContext bystander_context;
  const auto bystander = open(bystander_context);
  bystander->Write(start_of(v1::IMAGE_JPEG));
  EXPECT_EQ(read(*bystander).tick(), 0);
  grpc::ClientContext context;
  const auto stream = open(context);
  v1::WatchImagesRequest huge = start_of(v1::IMAGE_JPEG);
  huge.mutable_start()->set_name(std::string(std::size_t{1} << 20, 'x'));
  stream->Write(huge);
  v1::WatchImagesResponse response;
  EXPECT_FALSE(stream->Read(&response));
  EXPECT_EQ(stream->Finish().error_code(), StatusCode::RESOURCE_EXHAUSTED);
  step();
  EXPECT_EQ(read(*bystander).tick(), 1);
}

}  // namespace
}  // namespace kerf::rpc_test
