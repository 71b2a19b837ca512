// HTTP over TLS: files, calls, uploads, streams and their ends.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "kerf/v1/server.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "kerf/v1/stream.pb.h"
#include "server/service/wire/json.h"
#include "tests/support/wait_until.h"
#include "tests/ws/images_fixture.h"
#include "tests/ws/tls_fixture.h"

namespace kerf::ws_test {
namespace {

using std::chrono::milliseconds;

TEST_F(TlsTest, ServesFilesCallsAndUploads) {
  start();
  EXPECT_EQ(server_->http_url(), "https://127.0.0.1:" + std::to_string(port_));
  EXPECT_NE(server_->ready_line().find(R"("http":"https://127.0.0.1:)"), std::string::npos);
  const std::unique_ptr<TlsClient> client = connect();
  const Response index = request(*client, port_, "GET", "/");
  EXPECT_EQ(index.body, "<p>viewer</p>");
  EXPECT_FALSE(index.headers.contains("strict-transport-security")) << "this machine alone is served";
  const Response info = request(*client, port_, "POST", "/kerf.v1.ServerService/GetServerInfo", {}, "{}");
  EXPECT_EQ(info.headers.at("content-type"), "application/json");
  EXPECT_EQ(request(*client, port_, "HEAD", "/index.html").status, 200);

  std::string file;  // Many records, and more than a message may have.
  while (file.size() < (std::size_t{1} << 20) + 1) file += "# " + std::string(1000, 'x') + "\n";
  file += "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const Response made = request(*client, port_, "POST", "/sheets?format=obj", {}, file);
  ASSERT_EQ(made.status, 200) << made.body;
  v1::Sheet sheet;
  ASSERT_TRUE(wire::from_json(made.body, sheet).ok());
  EXPECT_EQ(sheet.num_vertices(), 3);
  EXPECT_EQ(ask("POST", "/sheets?format=obj", "Origin: https://elsewhere.example\r\n", file).status, 403);
}

TEST_F(TlsTest, ALargeAnswerIsWhole) {
  start();
  ASSERT_EQ(
      call("SheetService/CreateSheet",
           R"({"sheet_id":"a","paused":true,"scene":{"grid":{"columns":200,"rows":200,"width_m":1,"height_m":1}}})")
          .status,
      200);
  const Response state = call("SheetService/GetSheetState", R"({"name":"sheets/a"})");
  EXPECT_GT(state.body.size(), std::size_t{1} << 20);
  v1::SheetState read;
  EXPECT_TRUE(wire::from_json(state.body, read).ok());
}

TEST_F(TlsTest, ItsOwnPagesAreThoseOfHttps) {
  start();
  const std::string port = std::to_string(port_);
  for (const char* host : {"https://localhost:", "https://127.0.0.1:", "https://[::1]:"}) {
    EXPECT_EQ(call("ServerService/GetServerInfo", "{}", "Origin: " + (host + port) + "\r\n").status, 200) << host;
    EXPECT_EQ(open_stream("/watch", "Origin: " + (host + port) + "\r\n").handshake().status, 101) << host;
  }
  for (const char* host : {"http://localhost:", "http://127.0.0.1:", "https://elsewhere.example:"}) {
    EXPECT_EQ(call("ServerService/GetServerInfo", "{}", "Origin: " + (host + port) + "\r\n").status, 403) << host;
    EXPECT_EQ(open_stream("/watch", "Origin: " + (host + port) + "\r\n").handshake().status, 403) << host;
  }
}

TEST_F(TlsTest, WhereOthersReachItBrowsersAreToStayWithHttps) {
  app::Config config = test_config();
  config.http.host = "0.0.0.0";
  start(config);
  EXPECT_EQ(ask("GET", "/").headers.at("strict-transport-security"), "max-age=2592000");
}

v1::WatchRequest watch_of(const std::string& name) {
  v1::WatchRequest start;
  start.mutable_start()->set_name(name);
  return start;
}

TEST_F(TlsTest, AWatchStreamsUntilItsClientClosesIt) {
  start();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  RawWebSocket socket = open_stream("/watch");
  ASSERT_EQ(socket.handshake().status, 101);
  socket.send(RawWebSocket::kBinary, watch_of("sheets/a").SerializeAsString());
  const std::optional<RawWebSocket::Frame> frame = socket.read();
  ASSERT_TRUE(frame);
  v1::WatchResponse response;
  ASSERT_TRUE(response.ParseFromString(frame->payload));
  EXPECT_TRUE(response.has_frame());
  socket.send(RawWebSocket::kClose, "\x03\xe8");
  std::optional<RawWebSocket::Frame> next = socket.read();
  while (next && next->opcode != RawWebSocket::kClose) next = socket.read();
  ASSERT_TRUE(next);
  EXPECT_EQ(next->payload, "\x03\xe8");
  EXPECT_TRUE(socket.connection().closed_by_peer());
  EXPECT_TRUE(dynamic_cast<TlsClient&>(socket.connection()).was_told_goodbye());
  test::wait_until([&] { return metric("kerf_websocket_open_streams") == 0.0; });
}

TEST_F(TlsTest, TheBytesOfTlsDoNotCountAsFrames) {
  start();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  RawWebSocket socket = open_stream("/watch");
  // 10,000 messages, a record each: their heads are 60 kB, their records 220 kB more.
  v1::WatchRequest pace;
  pace.mutable_pace()->set_max_rate_hz(1.0);
  socket.send(RawWebSocket::kBinary, watch_of("sheets/a").SerializeAsString());
  for (int i = 0; i < 10'000; ++i) socket.send(RawWebSocket::kBinary, pace.SerializeAsString());
  socket.send(RawWebSocket::kClose, "\x03\xe8");
  EXPECT_EQ(socket.read_close(), 1000);
  RawWebSocket flood = open_stream("/watch");
  flood.send(RawWebSocket::kBinary, "", true, 0);
  for (int i = 0; i < 40'000; ++i) flood.send(RawWebSocket::kContinuation, "", true, 0);
  EXPECT_EQ(flood.read_close(), 1008);
}

class TlsPicturesTest : public TlsTest {
 protected:
  void SetUp() override {
    app::Config config = test_config();
    config.render = true;
    start(config);
    v1::ServerInfo info;
    ASSERT_TRUE(wire::from_json(call("ServerService/GetServerInfo", "{}").body, info).ok());
    if (info.renderer().starts_with("none: ")) GTEST_SKIP() << info.renderer();
    ASSERT_EQ(call("SheetService/CreateSheet",
                   R"({"sheet_id":"a","paused":true,"scene":{"pins":[{"edge":"TOP"}],
                       "grid":{"columns":8,"rows":8,"width_m":1,"height_m":1}}})")
                  .status,
              200);
  }
  [[nodiscard]] std::unique_ptr<TlsClient> play() const {
    std::unique_ptr<TlsClient> client = connect();
    client->send("GET /sheets/a.mjpeg?width=64&height=48&quality=70&rate=500 HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_TRUE(client->read_until("\r\n\r\n--kerf-picture\r\n"));
    return client;
  }
};

TEST_F(TlsPicturesTest, MjpegHasAPartForEachPictureAndAnEnd) {
  const std::unique_ptr<TlsClient> client = play();
  const std::string first = read_part(*client);
  EXPECT_TRUE(first == ask("GET", "/sheets/a.jpg?width=64&height=48&quality=70").body);
  client->send("a word in between");
  ASSERT_EQ(call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":1})").status, 200);
  EXPECT_TRUE(read_part(*client) != first);
  ASSERT_EQ(call("SheetService/DeleteSheet", R"({"name":"sheets/a"})").status, 200);
  EXPECT_TRUE(client->closed_by_peer());
  EXPECT_TRUE(client->was_told_goodbye());
  // The server closes it, though this client says nothing more.
  test::wait_until([&] { return metric("kerf_http_open_connections") == 1.0; });
}

TEST_F(TlsPicturesTest, AReaderOfMjpegThatLeavesIsLetGo) {
  for (const bool says_goodbye : {false, true}) {
    const std::unique_ptr<TlsClient> client = play();
    read_part(*client);
    EXPECT_EQ(metric("kerf_image_streams"), 1.0);
    says_goodbye ? client->say_goodbye() : client->hang_up();
    test::wait_until([&] { return metric("kerf_image_streams") == 0.0; });
  }
}

TEST_F(TlsPicturesTest, PicturesComeOverAWebSocket) {
  RawWebSocket socket = open_stream("/images");
  ASSERT_EQ(socket.handshake().status, 101);
  send(socket, start_of(v1::IMAGE_PNG));
  const std::optional<v1::Image> first = read_image(socket);
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->data() == ask("GET", "/sheets/a.png?width=64&height=48").body);
}

// Begins a step that would take long, and waits until it is under way.
class TlsStepTest : public TlsTest {
 protected:
  void begin(TlsClient& client) {
    ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
    const std::string body = R"({"name":"sheets/a","ticks":100000})";
    client.send("POST /kerf.v1.SheetService/StepSheet HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
                std::to_string(body.size()) + "\r\n\r\n" + body);
    test::wait_until([&] { return metric("kerf_ticks_total") != 0.0; });
  }
  // Waits until the sheet can be stepped again; the tick at which that was.
  [[nodiscard]] std::int64_t tick_of_end() const {
    Response response;
    do {  // Refused while the first one runs.
      response = call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":1})");
    } while (response.status == 400);
    v1::Sheet sheet;
    EXPECT_TRUE(wire::from_json(response.body, sheet).ok()) << response.body;
    return sheet.tick();
  }
};

TEST_F(TlsStepTest, EndsWhenItsClientHangsUp) {
  start();
  const std::unique_ptr<TlsClient> client = connect();
  begin(*client);
  client->hang_up();
  EXPECT_LT(tick_of_end(), 100'000);
}

TEST_F(TlsStepTest, EndsWhenItsClientSaysGoodbyeAndIsAnswered) {
  start();
  const std::unique_ptr<TlsClient> client = connect();
  begin(*client);
  client->say_goodbye();
  const Response response = client->read_response();
  ASSERT_EQ(response.status, 200) << response.body;
  v1::Sheet sheet;
  ASSERT_TRUE(wire::from_json(response.body, sheet).ok());
  EXPECT_LT(sheet.tick(), 100'000);
  EXPECT_TRUE(client->closed_by_peer());
  EXPECT_TRUE(client->was_told_goodbye());
}

TEST_F(TlsStepTest, RecordsWithoutAnEndAreNone) {
  start();
  const std::unique_ptr<TlsClient> client = connect();
  begin(*client);
  client->change_keys();  // Input that is no part of a request, and asks for output.
  const double ticks = metric("kerf_ticks_total");
  test::wait_until([&] { return metric("kerf_ticks_total") >= ticks + 100.0; });
  EXPECT_EQ(call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":1})").status, 400) << "still under way";
  client->send_raw("\x17\x03\x03");  // The beginning of a record.
  client->hang_up();
  EXPECT_LT(tick_of_end(), 100'000);
}

TEST_F(TlsStepTest, GoesOnWhenItsClientSendsTheNextRequest) {
  start();
  const std::unique_ptr<TlsClient> client = connect();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  const std::string body = R"({"name":"sheets/a","ticks":2000})";
  client->send("POST /kerf.v1.SheetService/StepSheet HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
               std::to_string(body.size()) + "\r\n\r\n" + body);
  test::wait_until([&] { return metric("kerf_ticks_total") != 0.0; });
  client->send("GET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\nGET /he");
  client->send("althz HTTP/1.1\r\nHost: localhost\r\n\r\n");
  v1::Sheet sheet;
  ASSERT_TRUE(wire::from_json(client->read_response().body, sheet).ok());
  EXPECT_EQ(sheet.tick(), 2000);
  EXPECT_EQ(client->read_response().body, "ready\n");
  EXPECT_EQ(client->read_response().body, "ok\n");
}

}  // namespace
}  // namespace kerf::ws_test
