#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "client/cpp/mirror.h"
#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/interaction.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "kerf/v1/stream.pb.h"
#include "server/base/random.h"
#include "server/service/wire/json.h"
#include "tests/ws/mirror_check.h"
#include "tests/ws/raw_client.h"
#include "tests/ws/running_server.h"

namespace kerf::ws_test {
namespace {

using std::chrono::milliseconds;
using Socket = RawWebSocket;

v1::WatchRequest start_of(const std::string& name, std::int32_t window = 0) {
  v1::WatchRequest request;
  request.mutable_start()->set_name(name);
  request.mutable_start()->set_window(window);
  return request;
}

v1::WatchRequest ack_of(std::int64_t sequence) {
  v1::WatchRequest request;
  request.mutable_ack()->set_sequence(sequence);
  return request;
}

void send(Socket& socket, const v1::WatchRequest& request) {
  socket.send(Socket::kBinary, request.SerializeAsString());
}

// Nothing at the end of the stream.
std::optional<v1::WatchResponse> read_message(Socket& socket) {
  const std::optional<Socket::Frame> frame = socket.read();
  v1::WatchResponse response;
  if (!frame || frame->opcode != Socket::kBinary || !frame->final || !response.ParseFromString(frame->payload)) {
    return std::nullopt;
  }
  return response;
}

int close_code(const std::optional<Socket::Frame>& frame) {
  if (!frame || frame->opcode != Socket::kClose || frame->payload.size() < 2) return 0;
  return (static_cast<std::uint8_t>(frame->payload[0]) << 8) | static_cast<std::uint8_t>(frame->payload[1]);
}

class WatchTest : public ::testing::Test {
 protected:
  void start(const app::Config& config = test_config()) {
    server_ = start_server(config);
    ASSERT_NE(server_, nullptr);
    port_ = port_of(server_->http_url());
    v1::Sheet sheet;
    ASSERT_TRUE(call("SheetService/CreateSheet",
                     R"({"sheet_id":"a","paused":true,"scene":{"pins":[{"edge":"TOP"}],
                         "integrator":{"kind":"EXPLICIT_LEAPFROG","max_substeps":200},
                         "grid":{"columns":12,"rows":12,"width_m":1,"height_m":1}}})",
                     sheet));
  }
  bool call(const std::string& method, const std::string& json, google::protobuf::Message& response) const {
    const Response answer = request(port_, "POST", "/kerf.v1." + method, {}, json);
    const bool ok = answer.status == 200 && wire::from_json(answer.body, response).ok();
    if (!ok) ADD_FAILURE() << method << ": " << answer.status << " " << answer.body;
    return ok;
  }
  v1::SheetState state() const {
    v1::SheetState state;
    call("SheetService/GetSheetState", R"({"name":"sheets/a"})", state);
    return state;
  }
  // Applies and acknowledges frames until the mirror shows `tick` and `topology_version`.
  static void follow(Socket& socket, client::Mirror& mirror, std::int64_t tick, std::int32_t topology_version) {
    while (mirror.tick() < tick || mirror.topology_version() < topology_version) {
      const std::optional<v1::WatchResponse> response = read_message(socket);
      ASSERT_TRUE(response && response->has_frame());
      const std::optional<std::string> wrong = mirror.apply(response->frame());
      ASSERT_FALSE(wrong) << *wrong;
      send(socket, ack_of(response->frame().sequence()));
    }
  }

  std::unique_ptr<app::Server> server_;
  int port_ = 0;
};

TEST_F(WatchTest, HandshakeTakesTheSubprotocolAndNoCompression) {
  start();
  Socket socket(port_,
                "Sec-WebSocket-Protocol: mqtt, kerf.v1\r\nSec-WebSocket-Extensions: permessage-deflate\r\n"
                "Origin: http://127.0.0.1:" +
                    std::to_string(port_) + "\r\n");
  EXPECT_EQ(socket.handshake().status, 101);
  EXPECT_EQ(socket.handshake().headers.at("sec-websocket-protocol"), "kerf.v1");
  EXPECT_EQ(socket.handshake().headers.at("sec-websocket-accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");  // RFC 6455, 1.3
  EXPECT_FALSE(socket.handshake().headers.contains("sec-websocket-extensions"));
}

TEST_F(WatchTest, HandshakeIsRefusedToStrangers) {
  start();
  const std::string protocol = "Sec-WebSocket-Protocol: kerf.v1\r\n";
  EXPECT_EQ(Socket(port_, "").handshake().status, 400);
  EXPECT_EQ(Socket(port_, "Sec-WebSocket-Protocol: kerf.v2\r\n").handshake().status, 400);
  EXPECT_EQ(Socket(port_, protocol + "Origin: http://evil.example.org\r\n").handshake().status, 403);
  EXPECT_EQ(Socket(port_, protocol + "Origin: null\r\n").handshake().status, 403);
  EXPECT_EQ(Socket(port_, protocol + "Host: rebound.example.org\r\n").handshake().status, 403);
  const Response elsewhere = request(port_, "GET", "/other",
                                     "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                                     "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                                         protocol);
  EXPECT_EQ(elsewhere.status, 404);
}

TEST_F(WatchTest, MirrorEqualsTheServerThroughFiftyCuts) {
  start();
  Socket socket(port_);
  send(socket, start_of("sheets/a"));
  client::Mirror mirror;
  follow(socket, mirror, 0, 0);
  ASSERT_EQ(difference(mirror, state()), "");
  SeededRandom random(7);
  int applied = 0;
  for (int i = 0; i < 200 && applied < 50; ++i) {
    v1::CreateCutRequest cut;
    cut.set_parent("sheets/a");
    v1::Polyline& line = *cut.mutable_cut()->mutable_curve()->mutable_polyline();
    for (int point = 0; point < 2; ++point) {
      v1::Vec2& end = *line.add_points();
      end.set_x(random.uniform(-0.2, 1.2));
      end.set_y(random.uniform(-0.2, 1.2));
    }
    v1::CutResult result;
    ASSERT_TRUE(call("CutService/CreateCut", wire::to_json(cut), result));
    applied += result.status() == v1::CutResult::APPLIED ? 1 : 0;
    v1::Sheet sheet;
    if (i % 2 == 1) {
      ASSERT_TRUE(call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":3})", sheet));
    }
    const v1::SheetState exact = state();
    follow(socket, mirror, exact.tick(), exact.topology_version());
    ASSERT_EQ(difference(mirror, exact), "") << "after cut " << i;
    EXPECT_EQ(result.topology_version(), mirror.topology_version());
    EXPECT_EQ(result.pieces(), mirror.num_pieces());
  }
  EXPECT_EQ(applied, 50);
}

TEST_F(WatchTest, PullsThroughTheStream) {
  start();
  Socket socket(port_);
  send(socket, start_of("sheets/a"));
  client::Mirror mirror;
  follow(socket, mirror, 0, 0);
  const std::array<double, 3> before = mirror.position(5);
  v1::WatchRequest grab;
  grab.mutable_grab()->set_grab_id("hand");
  grab.mutable_grab()->set_vertex(5);
  grab.mutable_grab()->mutable_target()->set_y(before[1] - 0.5);
  grab.mutable_grab()->mutable_target()->set_x(before[0]);
  grab.mutable_grab()->mutable_target()->set_z(before[2]);
  send(socket, grab);
  v1::WatchRequest drag;  // of a grab that there is not: answered after the grab was taken
  drag.mutable_drag()->set_grab_id("nobody");
  drag.mutable_drag()->mutable_target();
  send(socket, drag);
  while (true) {
    const std::optional<v1::WatchResponse> response = read_message(socket);
    ASSERT_TRUE(response);
    if (response->has_frame()) {
      ASSERT_FALSE(mirror.apply(response->frame()));
      send(socket, ack_of(response->frame().sequence()));
      continue;
    }
    ASSERT_TRUE(response->has_rejection());
    EXPECT_EQ(response->rejection().grab_id(), "nobody");
    break;
  }
  v1::Sheet sheet;
  ASSERT_TRUE(call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":30})", sheet));
  follow(socket, mirror, sheet.tick(), 0);
  EXPECT_LT(mirror.position(5)[1], before[1] - 0.1);
}

TEST_F(WatchTest, BrokenMessagesEndOnlyTheirOwnStream) {
  start();
  Socket bystander(port_);
  send(bystander, start_of("sheets/a"));
  client::Mirror mirror;
  follow(bystander, mirror, 0, 0);
  const std::string begin = start_of("sheets/a").SerializeAsString();
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
           Case{"long ping", 1002, [](Socket& s) { s.send(Socket::kPing, std::string(126, 'x')); }},
           Case{"too long", 1009, [](Socket& s) { s.send(Socket::kBinary, std::string(65537, 'x')); }},
           Case{"not a message", 1008, [](Socket& s) { s.send(Socket::kBinary, "\xff\xff\xff"); }},
           Case{"empty", 1008, [](Socket& s) { s.send(Socket::kBinary, ""); }},
           Case{"no start", 1008, [](Socket& s) { send(s, ack_of(1)); }},
           Case{"unknown sheet", 1008, [](Socket& s) { send(s, start_of("sheets/none")); }},
           Case{"window", 1008, [](Socket& s) { send(s, start_of("sheets/a", 9)); }},
       }) {
    Socket socket(port_);
    broken.send(socket);
    EXPECT_EQ(socket.read_close(), broken.code) << broken.what;
  }
  v1::Sheet sheet;
  ASSERT_TRUE(call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":2})", sheet));
  follow(bystander, mirror, sheet.tick(), 0);
  EXPECT_EQ(difference(mirror, state()), "");
}

TEST_F(WatchTest, SaysInTheCloseFrameWhatWasWrong) {
  start();
  Socket socket(port_);
  send(socket, start_of("sheets/a"));
  ASSERT_TRUE(read_message(socket));
  send(socket, ack_of(77));
  std::optional<Socket::Frame> frame = socket.read();
  while (frame && frame->opcode == Socket::kBinary) frame = socket.read();
  EXPECT_EQ(close_code(frame), 1008);
  EXPECT_NE(frame->payload.find("ACK_OUT_OF_RANGE"), std::string::npos) << frame->payload;
  EXPECT_LE(frame->payload.size(), 125U);
}

TEST_F(WatchTest, TakesFragmentsAndPings) {
  start();
  Socket socket(port_);
  const std::string begin = start_of("sheets/a").SerializeAsString();
  socket.send(Socket::kBinary, begin.substr(0, 3), true, 0);
  socket.send(Socket::kPing, "are you there");
  socket.send(Socket::kContinuation, begin.substr(3));
  bool pong = false;
  bool frame = false;
  while (!pong || !frame) {
    const std::optional<Socket::Frame> next = socket.read();
    ASSERT_TRUE(next);
    pong = pong || (next->opcode == Socket::kPong && next->payload == "are you there");
    frame = frame || next->opcode == Socket::kBinary;
  }
  socket.send(Socket::kClose, "\x03\xe8");
  EXPECT_EQ(socket.read_close(), 1000);
}

TEST_F(WatchTest, FramesThatHoldNextToNothingAreBounded) {
  start();
  struct Flood {
    const char* what;
    int frames;  // many more than are taken in the time that sending them takes
    std::function<void(Socket&)> begin;
    std::function<void(Socket&)> send;
  };
  const auto begin = [](Socket& s) { send(s, start_of("sheets/a")); };
  v1::WatchRequest pace;
  pace.mutable_pace()->set_max_rate_hz(1.0);
  for (const Flood& flood : {
           Flood{"pings", 2'000, begin, [](Socket& s) { s.send(Socket::kPing, ""); }},
           Flood{"pongs", 2'000, begin, [](Socket& s) { s.send(Socket::kPong, "unasked"); }},
           Flood{"empty fragments", 40'000, [](Socket& s) { s.send(Socket::kBinary, "", true, 0); },
                 [](Socket& s) { s.send(Socket::kContinuation, "", true, 0); }},
           Flood{"tiny messages", 40'000, begin, [&](Socket& s) { send(s, pace); }},
       }) {
    Socket socket(port_);
    flood.begin(socket);
    for (int i = 0; i < flood.frames; ++i) flood.send(socket);
    std::optional<Socket::Frame> frame = socket.read();
    while (frame && frame->opcode != Socket::kClose) frame = socket.read();
    EXPECT_EQ(close_code(frame), 1008) << flood.what;
    EXPECT_NE(frame.value_or(Socket::Frame()).payload.find("TOO_MANY_FRAMES"), std::string::npos) << flood.what;
  }
}

TEST_F(WatchTest, AsManyPingsAsAreTakenAtOnceAreAnswered) {
  start();
  Socket socket(port_);
  for (int i = 0; i < 200; ++i) socket.send(Socket::kPing, std::to_string(i));
  for (int i = 0; i < 200; ++i) {
    const std::optional<Socket::Frame> pong = socket.read();
    ASSERT_TRUE(pong && pong->opcode == Socket::kPong);
    EXPECT_EQ(pong->payload, std::to_string(i));
  }
}

TEST_F(WatchTest, ASlowReaderGetsNothingOlderThanItsWindow) {
  start();
  Socket socket(port_);
  send(socket, start_of("sheets/a", 2));
  client::Mirror mirror;
  const auto take = [&]() -> std::optional<v1::Frame> {
    const std::optional<v1::WatchResponse> response = read_message(socket);
    if (!response || !response->has_frame() || mirror.apply(response->frame())) return std::nullopt;
    return response->frame();
  };
  v1::Sheet sheet;
  const auto step = [&] { return call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":1})", sheet); };
  ASSERT_TRUE(take());
  EXPECT_EQ(mirror.tick(), 0);
  ASSERT_TRUE(step());
  ASSERT_TRUE(take());
  EXPECT_EQ(mirror.tick(), 1);
  // Two frames are unacknowledged: whatever happens now is not sent.
  v1::CutResult cut;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(step());
    if (i != 10) continue;
    ASSERT_TRUE(call("CutService/CreateCut",
                     R"({"parent":"sheets/a","cut":{"curve":{"circle":{"center":{"x":0.5,"y":0.5},"radius_m":0.2}}}})",
                     cut));
  }
  send(socket, ack_of(1));
  const std::optional<v1::Frame> third = take();
  ASSERT_TRUE(third);
  EXPECT_EQ(third->sequence(), 3);
  EXPECT_EQ(third->tick(), 21) << "the newest, nothing in between";
  EXPECT_EQ(third->stats().skipped(), 19);
  EXPECT_EQ(mirror.topology_version(), cut.topology_version());
  EXPECT_EQ(difference(mirror, state()), "");
}

TEST_F(WatchTest, AReaderThatDoesNotAcknowledgeIsEnded) {
  app::Config config = test_config();
  config.limits.watch_ack_timeout = milliseconds(150);
  start(config);
  Socket socket(port_);
  send(socket, start_of("sheets/a"));
  std::optional<v1::WatchResponse> response = read_message(socket);
  ASSERT_TRUE(response && response->has_frame());
  response = read_message(socket);
  ASSERT_TRUE(response && response->has_ended());
  EXPECT_EQ(response->ended().reason(), v1::Ended::TOO_SLOW);
  const std::optional<Socket::Frame> close = socket.read();
  EXPECT_EQ(close_code(close), 1013);
  EXPECT_EQ(close->payload.substr(2, 8), "TOO_SLOW");
}

TEST_F(WatchTest, ASilentPeerIsCutOff) {
  app::Config config = test_config();
  config.http_options.silence_timeout = milliseconds(200);
  start(config);
  Socket socket(port_);
  ASSERT_EQ(socket.handshake().status, 101);
  EXPECT_EQ(socket.connection().read_exactly(2), std::string("\x89\0", 2)) << "a ping";
  EXPECT_TRUE(socket.connection().closed_by_peer()) << "it was not answered";
}

TEST_F(WatchTest, DeletionAndStopAreToldBeforeTheClose) {
  start();
  v1::Sheet other;
  ASSERT_TRUE(call("SheetService/CreateSheet",
                   R"({"sheet_id":"b","scene":{"grid":{"columns":5,"rows":5,"width_m":1,"height_m":1}}})", other));
  Socket deleted(port_);
  send(deleted, start_of("sheets/a"));
  ASSERT_TRUE(read_message(deleted));
  ASSERT_EQ(request(port_, "POST", "/kerf.v1.SheetService/DeleteSheet", {}, R"({"name":"sheets/a"})").status, 200);
  std::optional<v1::WatchResponse> last = read_message(deleted);
  ASSERT_TRUE(last && last->has_ended());
  EXPECT_EQ(last->ended().reason(), v1::Ended::SHEET_DELETED);
  EXPECT_EQ(deleted.read_close(), 1000);

  Socket open(port_);
  send(open, start_of("sheets/b"));
  ASSERT_TRUE(read_message(open));
  std::thread stop([this] { server_->stop(); });
  std::optional<v1::WatchResponse> response = read_message(open);
  while (response && response->has_frame()) response = read_message(open);
  EXPECT_TRUE(response && response->has_ended());
  EXPECT_EQ(response->ended().reason(), v1::Ended::SERVER_STOPPING);
  EXPECT_EQ(open.read_close(), 1001);
  stop.join();
}

}  // namespace
}  // namespace kerf::ws_test
