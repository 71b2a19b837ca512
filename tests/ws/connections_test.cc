// Connections: how long they last, how many there may be, and what their end does to a call.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "kerf/v1/sheets.pb.h"
#include "server/service/wire/json.h"
#include "tests/support/wait_until.h"
#include "tests/ws/http_fixture.h"

namespace kerf::ws_test {
namespace {

using std::chrono::milliseconds;

TEST_F(HttpServerTest, RefusesWhatIsNotHttp) {
  start();
  for (const char* bytes :
       {"garbage\r\n\r\n", "GET / HTTP/9.9\r\n\r\n", "GET /\r\n\r\n", "\x16\x03\x01\x02\x01\xfc\x03\x03\r\n\r\n",
        "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n",
        "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n",
        "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"}) {
    RawClient client(port_);
    client.send(bytes);
    EXPECT_EQ(client.read_response().status, 400) << bytes;
    EXPECT_TRUE(client.closed_by_peer()) << bytes;
  }
  EXPECT_EQ(get("/healthz").status, 200);
}

TEST_F(HttpServerTest, KeepsConnectionsAndTheOrderOfAnswers) {
  start();
  RawClient client(port_);
  client.send(
      "POST /kerf.v1.ServerService/GetServerInfo HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
      "2\r\n{}\r\n0\r\n\r\nGET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\n"
      "GET /none HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(client.read_response().headers.at("content-type"), "application/json");
  EXPECT_EQ(client.read_response().body, "ready\n");
  EXPECT_EQ(client.read_response().status, 404);
  client.send(
      "POST /kerf.v1.ServerService/GetServerInfo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n"
      "Expect: 100-continue\r\n\r\n");
  EXPECT_EQ(client.read_response().status, 100);
  client.send("{}");
  EXPECT_EQ(client.read_response().status, 200);
  client.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(client.read_response().status, 200);
  EXPECT_TRUE(client.closed_by_peer());
}

TEST_F(HttpServerTest, WaitsForNobodyForEver) {
  app::Config config = test_config();
  config.http_options.request_timeout = milliseconds(100);
  config.http_options.idle_timeout = milliseconds(150);
  start(config);
  RawClient silent(port_);
  RawClient slow(port_);
  slow.send("GET /healthz HT");
  RawClient stalled(port_);
  stalled.send("POST /kerf.v1.ServerService/GetServerInfo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n{");
  RawClient idle(port_);
  idle.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(idle.read_response().status, 200);
  EXPECT_TRUE(silent.closed_by_peer());
  EXPECT_TRUE(slow.closed_by_peer());
  EXPECT_TRUE(stalled.closed_by_peer());
  EXPECT_TRUE(idle.closed_by_peer());
}

TEST_F(HttpServerTest, AResponseMayTakeLongWhileItIsTaken) {
  using Clock = std::chrono::steady_clock;
  app::Config config = test_config();
  config.http_options.write_timeout = milliseconds(1000);
  start(config);
  ASSERT_EQ(
      call("SheetService/CreateSheet",
           R"({"sheet_id":"large","paused":true,"scene":{"grid":{"columns":300,"rows":300,"width_m":1,"height_m":1}}})")
          .status,
      200);
  const std::string request =
      "POST /kerf.v1.SheetService/GetSheetState HTTP/1.1\r\nHost: localhost\r\nContent-Length: 23\r\n\r\n"
      R"({"name":"sheets/large"})";
  RawClient slow(port_);
  slow.shrink_receive_buffer(64 << 10);
  slow.send(request);
  const std::string head = slow.read_until("\r\n\r\n").value_or("");
  std::size_t left = std::stoul(head.substr(head.find("Content-Length: ") + 16));
  ASSERT_GT(left, std::size_t{8} << 20) << "more than the kernel would keep";
  const std::size_t part = left / 8 + 1;
  const Clock::time_point slowly_from = Clock::now();
  while (left > 0) {
    const std::size_t wanted = std::min(part, left);
    ASSERT_TRUE(slow.read_exactly(wanted)) << left << " bytes short";
    left -= wanted;
    // Slower than all of it is allowed to take at a time, and never silent for so long.
    if (left > 0) std::this_thread::sleep_for(milliseconds(250));
  }
  EXPECT_GT(Clock::now() - slowly_from, milliseconds(1500));

  RawClient stalled(port_);
  stalled.shrink_receive_buffer(64 << 10);
  stalled.send(request);
  ASSERT_TRUE(stalled.read_until("\r\n\r\n"));
  std::this_thread::sleep_for(milliseconds(1500));
  EXPECT_FALSE(stalled.read_exactly(std::size_t{8} << 20)) << "of which nothing was taken for too long";
}

TEST_F(HttpServerTest, TurnsAwayConnectionsBeyondTheLimit) {
  app::Config config = test_config();
  config.http_options.max_connections = 2;
  start(config);
  const auto ask = [](RawClient& client) {
    client.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return client.read_response().status;
  };
  RawClient first(port_);
  EXPECT_EQ(ask(first), 200);
  {
    RawClient second(port_);
    EXPECT_EQ(ask(second), 200);
    RawClient third(port_);
    EXPECT_TRUE(third.closed_by_peer());
    second.send("GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    const std::string page = second.read_response().body;
    EXPECT_NE(page.find("\nkerf_http_refused_connections_total{limit=\"all\"} 1\n"), std::string::npos) << page;
    EXPECT_NE(page.find("\nkerf_http_open_connections 2\n"), std::string::npos) << page;
    EXPECT_TRUE(second.closed_by_peer());
  }
  // The place is free once the server has seen the second one go.
  int status = 0;
  for (int attempt = 0; attempt < 1000 && status != 200; ++attempt) {
    RawClient next(port_);
    status = ask(next);
  }
  EXPECT_EQ(status, 200);
}

using Clients = std::vector<std::unique_ptr<RawClient>>;

TEST_F(HttpServerTest, OneAddressHasSoManyConnectionsAndAnotherItsOwn) {
  app::Config config = test_config();
  config.max_connections_per_address = 8;
  start(config);
  Clients slow;  // each says one byte, and holds its place
  for (int i = 0; i < 7; ++i) slow.emplace_back(std::make_unique<RawClient>(port_))->send("G");
  RawClient last(port_);
  EXPECT_EQ(ws_test::get(last, "/healthz").status, 200);
  for (const bool speaks_first : {false, true}) {
    RawClient refused(port_);
    if (speaks_first) refused.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    const Response response = refused.read_response();
    EXPECT_EQ(response.status, 503);
    EXPECT_EQ(response.headers.at("retry-after"), "1");
    EXPECT_EQ(response.headers.at("content-type"), "application/json");
    EXPECT_NE(response.body.find("TOO_MANY_CONNECTIONS"), std::string::npos) << response.body;
    EXPECT_TRUE(refused.closed_by_peer());
  }
  RawClient elsewhere(port_, "127.0.0.2");
  EXPECT_EQ(ws_test::get(elsewhere, "/healthz").status, 200);
  const std::string page = ws_test::get(elsewhere, "/metrics").body;
  EXPECT_NE(page.find("\nkerf_http_refused_connections_total{limit=\"address\"} 2\n"), std::string::npos) << page;
  EXPECT_NE(page.find("\nkerf_http_refused_connections_total{limit=\"all\"} 0\n"), std::string::npos) << page;
  EXPECT_NE(page.find("\nkerf_http_open_connections 9\n"), std::string::npos) << page;
  slow.pop_back();
  test::wait_until([&] {
    return ws_test::get(elsewhere, "/metrics").body.find("\nkerf_http_open_connections 8\n") != std::string::npos;
  });
  RawClient next(port_);
  EXPECT_EQ(ws_test::get(next, "/healthz").status, 200);
}

TEST_F(HttpServerTest, AThousandSlowConnectionsOfOneAddressKeepNobodyElseOut) {
  start();
  Clients slow;
  for (int i = 0; i < 1000; ++i) slow.emplace_back(std::make_unique<RawClient>(port_))->send("GET / HTTP/1.1\r\nX");
  for (int i = 0; i < 5; ++i) {
    RawClient elsewhere(port_, "127.0.0.2");
    EXPECT_EQ(ws_test::get(elsewhere, "/healthz").status, 200);
  }
}

TEST_F(HttpServerTest, WithoutALimitOneAddressMayHaveAllConnections) {
  app::Config config = test_config();
  config.max_connections_per_address = 0;
  start(config);
  Clients clients;
  for (int i = 0; i < 200; ++i) clients.push_back(std::make_unique<RawClient>(port_));
  EXPECT_EQ(ws_test::get(*clients.back(), "/healthz").status, 200);
}

TEST_F(HttpServerTest, WithoutRoomForAllOneAddressIsClosedAtOnce) {
  app::Config config = test_config();
  config.max_connections_per_address = 2;
  config.http_options.max_connections = 1;
  start(config);
  RawClient first(port_);
  EXPECT_EQ(ws_test::get(first, "/healthz").status, 200);
  RawClient second(port_);
  EXPECT_TRUE(second.closed_by_peer());
}

TEST_F(HttpServerTest, ListensAtEachAddressOfAName) {
  app::Config config = test_config();
  config.http.host = "localhost";
  start(config);
  EXPECT_EQ(get("/healthz").status, 200);
  EXPECT_EQ(server_->http_url(), "http://localhost:" + std::to_string(port_));
}

// One call as it is sent.
std::string step_request(std::int32_t ticks) {
  const std::string body = R"({"name":"sheets/a","ticks":)" + std::to_string(ticks) + "}";
  return "POST /kerf.v1.SheetService/StepSheet HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
         std::to_string(body.size()) + "\r\n\r\n" + body;
}

constexpr std::int32_t kManyTicks = 100'000;

TEST_F(HttpServerTest, AStepWhoseClientHangsUpEnds) {
  start();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  {
    RawClient client(port_);
    ASSERT_TRUE(client.send(step_request(kManyTicks)));
    test::wait_until([&] { return metric("kerf_ticks_total") != 0.0; });
  }
  Response response;
  do {  // Refused while the first one runs.
    response = call("SheetService/StepSheet", R"({"name":"sheets/a","ticks":1})");
  } while (response.status == 400);
  ASSERT_EQ(response.status, 200) << response.body;
  v1::Sheet sheet;
  ASSERT_TRUE(wire::from_json(response.body, sheet).ok());
  EXPECT_LT(sheet.tick(), kManyTicks);
}

TEST_F(HttpServerTest, AStepWhoseClientEndsItsHalfIsAnsweredWithWhatWasDone) {
  start();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  RawClient client(port_);
  ASSERT_TRUE(client.send(step_request(kManyTicks)));
  test::wait_until([&] { return metric("kerf_ticks_total") != 0.0; });
  client.end_sending();
  const Response response = client.read_response();
  ASSERT_EQ(response.status, 200) << response.body;
  v1::Sheet sheet;
  ASSERT_TRUE(wire::from_json(response.body, sheet).ok());
  EXPECT_GT(sheet.tick(), 0);
  EXPECT_LT(sheet.tick(), kManyTicks);
  EXPECT_TRUE(client.closed_by_peer());
}

TEST_F(HttpServerTest, AStepWhoseClientSendsItsNextRequestGoesOn) {
  start();
  ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  RawClient client(port_);
  ASSERT_TRUE(client.send(step_request(200)));
  ASSERT_TRUE(client.send(step_request(30)));
  for (const std::int64_t tick : {200, 230}) {
    const Response response = client.read_response();
    ASSERT_EQ(response.status, 200) << response.body;
    v1::Sheet sheet;
    ASSERT_TRUE(wire::from_json(response.body, sheet).ok());
    EXPECT_EQ(sheet.tick(), tick);
  }
}

TEST_F(HttpServerTest, NeverSharesAPort) {
  start();
  app::Config config = test_config();
  config.http.port = port_;
  const auto second = app::Server::start(config, [](std::string_view) {});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().reason, "ADDRESS_IN_USE");
  EXPECT_NE(second.error().message.find(std::to_string(port_)), std::string::npos) << second.error().message;
  EXPECT_EQ(get("/healthz").status, 200);
}

TEST_F(HttpServerTest, StopsWithIdleConnectionsOpen) {
  start();
  RawClient idle(port_);
  idle.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(idle.read_response().status, 200);
  RawClient silent(port_);
  server_->stop();
  EXPECT_TRUE(idle.closed_by_peer());
  EXPECT_TRUE(silent.closed_by_peer());
  EXPECT_EQ(get("/healthz").status, 0);
  server_->stop();
}

}  // namespace
}  // namespace kerf::ws_test
