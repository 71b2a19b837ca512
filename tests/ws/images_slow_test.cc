// Tests readers of pictures that stall, and messages that no reader should send: their cost, borne by no other reader.

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "kerf/v1/render.pb.h"
#include "tests/support/wait_until.h"
#include "tests/ws/images_fixture.h"

namespace kerf::ws_test {
namespace {

using std::chrono::milliseconds;

constexpr int kTicks = 20;
constexpr int kReceiveBytes = 8 << 10;  // that a stalled reader's kernel takes; pictures for it are far larger
constexpr std::string_view kImages = "/images";
constexpr std::string_view kSubprotocol = "Sec-WebSocket-Protocol: kerf.v1\r\n";

// Readers that are given up on soon, beside one that owes no acknowledgements: that it is served depends on no time.
class SlowImagesTest : public ImagesTest {
 protected:
  SlowImagesTest() {
    config_.limits.watch_ack_timeout = milliseconds(300);
    config_.http_options.write_timeout = milliseconds(300);
    config_.http_options.silence_timeout = milliseconds(600);
  }
  void SetUp() override {
    ImagesTest::SetUp();
    if (IsSkipped()) return;
    lively_ = std::make_unique<RawClient>(port_);
    lively_->send("GET /sheets/a.mjpeg?width=64&height=48 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    ASSERT_TRUE(lively_->read_until("\r\n\r\n--kerf-picture\r\n"));
    last_ = read_part(*lively_);
    ASSERT_FALSE(last_.empty());
  }

  // Steps the sheet and reads each tick's picture.
  void follow() {
    for (int tick = 0; tick < kTicks; ++tick) {
      step();
      const std::string picture = read_part(*lively_);
      ASSERT_FALSE(picture.empty());
      EXPECT_NE(picture, last_) << "the sheet falls";
      last_ = picture;
    }
  }
  void wait_for_one_stream() {
    test::wait_until([&] { return metric("kerf_image_streams") == 1.0; });
  }
  // For others than the lively reader.
  double rendered() { return metric("kerf_pictures_rendered_total") - (1.0 + kTicks); }

 private:
  std::unique_ptr<RawClient> lively_;
  std::string last_;  // its last picture
};

TEST_F(SlowImagesTest, AStalledReaderOfMjpegIsClosedAndCostsNobodyElseAnything) {
  RawClient stalled(port_);
  stalled.shrink_receive_buffer(kReceiveBytes);
  stalled.send("GET /sheets/a.mjpeg?width=1600&height=1200&quality=100 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  const std::optional<std::string> head = stalled.read_until("Content-Length: ");
  ASSERT_TRUE(head);
  const std::size_t picture_bytes = std::stoul(stalled.read_until("\r\n\r\n").value_or("0"));
  EXPECT_GT(picture_bytes, 200U << 10) << "far more than fits into the ways of the kernel";
  follow();
  wait_for_one_stream();
  EXPECT_EQ(rendered(), 1.0) << "a picture it did not take is the last";
  EXPECT_LE(stalled.read_rest().size(), picture_bytes + 100) << "nothing waited for it";
}

TEST_F(ImagesTest, WhoSaysAWordAndHangsUpGivesItsStreamBack) {
  for (const bool whole : {true, false}) {
    RawClient gone(port_);
    gone.send("GET /sheets/a.mjpeg?width=64&height=48 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    ASSERT_TRUE(gone.read_until("--kerf-picture\r\n"));
    ASSERT_FALSE(read_part(gone).empty());
    EXPECT_EQ(metric("kerf_image_streams"), 1.0);
    gone.send("x");
    EXPECT_EQ(metric("kerf_image_streams"), 1.0) << "one byte ends nothing";
    if (whole) {
      gone.hang_up();
    } else {
      gone.end_sending();
    }
    test::wait_until([&] { return metric("kerf_image_streams") == 0.0; });
  }
}

// A picture without acknowledgement ends the connection of a reader that has vanished.
TEST_F(ImagesTest, APictureIsSentAgainWhereThereIsNoOther) {
  app::Config config = config_;
  config.http_options.picture_repeat = milliseconds(50);
  server_ = start_server(config);
  port_ = port_of(server_->http_url());
  call("SheetService/CreateSheet",
       R"({"sheet_id":"a","paused":true,"scene":{"pins":[{"edge":"TOP"}],
           "grid":{"columns":8,"rows":8,"width_m":1,"height_m":1}}})");
  RawClient reader(port_);
  reader.send("GET /sheets/a.mjpeg?width=64&height=48 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  ASSERT_TRUE(reader.read_until("--kerf-picture\r\n"));
  const std::string picture = read_part(reader);
  ASSERT_FALSE(picture.empty());
  EXPECT_EQ(read_part(reader), picture);
  EXPECT_EQ(read_part(reader), picture);
  EXPECT_EQ(metric("kerf_pictures_rendered_total"), 1.0) << "nothing is drawn for it";
  step();
  std::string next = picture;
  while (next == picture) next = read_part(reader);
  EXPECT_FALSE(next.empty()) << "the new one is sent like any";
}

TEST_F(SlowImagesTest, AReaderThatTakesButDoesNotAcknowledgeIsTold) {
  Socket stalled(port_, kSubprotocol, kImages);
  v1::WatchImagesRequest start = start_of(v1::IMAGE_JPEG, 320, 240);
  start.mutable_start()->set_window(2);
  send(stalled, start);
  follow();
  std::optional<Socket::Frame> frame;
  v1::WatchImagesResponse response;
  int pictures = 0;
  do {
    frame = stalled.read();
    ASSERT_TRUE(frame && frame->opcode == Socket::kBinary && response.ParseFromString(frame->payload));
    pictures += response.has_image() ? 1 : 0;
  } while (!response.has_ended());
  EXPECT_EQ(response.ended().reason(), v1::Ended::TOO_SLOW);
  EXPECT_EQ(stalled.read_close(), 1013);
  EXPECT_GE(pictures, 1);
  EXPECT_LE(pictures, 2) << "its window";
  wait_for_one_stream();
  EXPECT_LE(rendered(), 2.0);
}

TEST_F(SlowImagesTest, AReaderThatDoesNotEvenReadIsCutOff) {
  Socket stalled(port_, kSubprotocol, kImages);
  stalled.connection().shrink_receive_buffer(kReceiveBytes);
  send(stalled, start_of(v1::IMAGE_PNG, 1600, 1200));
  follow();
  test::wait_until([&] { return rendered() >= 1.0; });
  wait_for_one_stream();
  EXPECT_LE(rendered(), 2.0) << "as many as its window has";
  // The connection is closed, too.
  test::wait_until([&] { return metric("kerf_websocket_open_streams") == 0.0; });
}

// Whatever it says meanwhile.
TEST_F(SlowImagesTest, AReaderThatOnlySendsIsCutOff) {
  Socket stalled(port_, kSubprotocol, kImages);
  stalled.connection().shrink_receive_buffer(kReceiveBytes);
  send(stalled, start_of(v1::IMAGE_PNG, 1600, 1200));
  follow();
  v1::WatchImagesRequest pace;
  pace.mutable_pace()->set_max_rate_hz(100.0);
  while (metric("kerf_image_streams") != 1.0) send(stalled, pace);
  EXPECT_LE(rendered(), 2.0) << "as many as its window has";
}

TEST_F(ImagesTest, BrokenMessagesEndOnlyTheirOwnStream) {
  const v1::WatchImagesRequest start = start_of(v1::IMAGE_JPEG);
  Socket bystander(port_, kSubprotocol, kImages);
  send(bystander, start);
  ASSERT_TRUE(read_image(bystander));
  const std::string begin = start.SerializeAsString();
  v1::WatchImagesRequest ack;
  ack.mutable_ack()->set_sequence(1);
  v1::WatchImagesRequest nobody = start;
  nobody.mutable_start()->set_name("sheets/nobody");
  v1::WatchImagesRequest small = start;
  small.mutable_start()->mutable_view()->set_width_px(15);
  struct Case {
    const char* what;
    int code;
    std::function<void(Socket&)> send;
  };
  for (const Case& broken : {
           Case{"text", 1003, [](Socket& s) { s.send(Socket::kText, "hello"); }},
           Case{"unmasked", 1002, [&](Socket& s) { s.send(Socket::kBinary, begin, false); }},
           Case{"reserved bit", 1002, [&](Socket& s) { s.send(Socket::kBinary, begin, true, 0xC0); }},
           Case{"reserved opcode", 1002, [&](Socket& s) { s.send(3, begin); }},
           Case{"continuation of nothing", 1002, [&](Socket& s) { s.send(Socket::kContinuation, begin); }},
           Case{"too long", 1009, [](Socket& s) { s.send(Socket::kBinary, std::string((64 << 10) + 1, 'x')); }},
           Case{"too long in parts", 1009,
                [](Socket& s) {
                  s.send(Socket::kBinary, std::string(60 << 10, 'x'), true, 0);
                  s.send(Socket::kContinuation, std::string(60 << 10, 'x'));
                }},
           Case{"not a message", 1008, [](Socket& s) { s.send(Socket::kBinary, "\xff\xff\xff"); }},
           Case{"as long as may be, but not a message", 1008,
                [](Socket& s) { s.send(Socket::kBinary, std::string(64 << 10, '\xff')); }},
           Case{"empty", 1008, [](Socket& s) { s.send(Socket::kBinary, ""); }},
           Case{"no start", 1008, [&](Socket& s) { send(s, ack); }},
           Case{"unknown sheet", 1008, [&](Socket& s) { send(s, nobody); }},
           Case{"too small a picture", 1008, [&](Socket& s) { send(s, small); }},
           Case{"two starts", 1008,
                [&](Socket& s) {
                  send(s, start);
                  send(s, start);
                }},
       }) {
    Socket socket(port_, kSubprotocol, kImages);
    broken.send(socket);
    EXPECT_EQ(socket.read_close(), broken.code) << broken.what;
  }
  step();
  const std::optional<v1::Image> image = read_image(bystander);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->sequence(), 2);
  EXPECT_EQ(image->tick(), 1);
}

}  // namespace
}  // namespace kerf::ws_test
