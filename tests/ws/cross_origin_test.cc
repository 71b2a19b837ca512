// Pages of other origins: which may read answers, and what the headers say about that.
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "server/service/ws/access.h"
#include "tests/ws/http_fixture.h"

namespace kerf::ws_test {
namespace {

constexpr const char* kPage = "Origin: http://localhost:3000\r\n";
constexpr const char* kOther = "Origin: http://localhost:3001\r\n";

class CrossOriginTest : public HttpServerTest {
 protected:
  void start_sharing() {
    app::Config config = test_config();
    config.allowed_origins = {"http://localhost:3000", "https://viewer.example.org"};
    start(config);
    ASSERT_EQ(call("SheetService/CreateSheet", kSheet).status, 200);
  }
  static std::string value(const Response& response, const std::string& name) {
    const auto found = response.headers.find(name);
    return found == response.headers.end() ? "" : found->second;
  }
  static void expect_shared(const Response& response, const std::string& what) {
    EXPECT_EQ(value(response, "access-control-allow-origin"), "http://localhost:3000") << what;
    EXPECT_EQ(value(response, "access-control-allow-credentials"), "true") << what;
    EXPECT_NE(value(response, "vary").find("Origin"), std::string::npos) << what;
    EXPECT_EQ(value(response, "cross-origin-resource-policy"), "cross-origin") << what;
  }
  static void expect_not_shared(const Response& response, const std::string& what) {
    for (const auto& [name, text] : response.headers) {
      EXPECT_FALSE(name.starts_with("access-control-")) << what << ": " << name << ": " << text;
    }
    EXPECT_EQ(value(response, "cross-origin-resource-policy"), "same-origin") << what;
  }
};

struct Route {
  std::string_view method;
  std::string_view target;
  std::string_view body;
  int status;
};

const std::vector<Route>& routes() {
  static const std::vector<Route> all = {
      {"GET", "/", "", 200},
      {"GET", "/assets/app-12.js", "", 200},
      {"GET", "/healthz", "", 200},
      {"GET", "/metrics", "", 200},
      {"GET", "/nothing", "", 404},
      {"GET", "/kerf.v1.SheetService/GetSheet", "", 405},
      {"GET", "/sheets/a.rec", "", 200},
      {"GET", "/sheets/none.rec", "", 404},
      {"GET", "/sheets/none.mjpeg", "", 0},
      {"GET", "/sheets/a.png?width=1", "", 400},
      {"DELETE", "/", "", 405},
      {"POST", "/kerf.v1.SheetService/ListSheets", "{}", 200},
      {"POST", "/kerf.v1.SheetService/GetSheet", R"({"name":"sheets/none"})", 404},
      {"POST", "/kerf.v1.SheetService/GetSheet", "{", 400},
      {"POST", "/sheets?format=stl", "solid", 400},
      {"POST", "/login", "{}", 400},
  };
  return all;
}

TEST_F(CrossOriginTest, EveryAnswerToAnAllowedPageIsShared) {
  start_sharing();
  for (const Route& route : routes()) {
    const Response response = request(port_, route.method, route.target, kPage, route.body);
    if (route.status != 0) {
      EXPECT_EQ(response.status, route.status) << route.target << response.body;
    }
    expect_shared(response, std::string(route.method) + " " + std::string(route.target));
  }
}

TEST_F(CrossOriginTest, NoOtherPageIsTold) {
  start_sharing();
  for (const Route& route : routes()) {
    for (const char* const origin : {kOther, "Origin: null\r\n", "Origin: http://evil.example.org\r\n", ""}) {
      const Response response = request(port_, route.method, route.target, origin, route.body);
      expect_not_shared(response, std::string(route.target) + " " + origin);
      EXPECT_NE(value(response, "vary").find("Origin"), std::string::npos) << "caches keep answers apart";
    }
  }
}

TEST_F(CrossOriginTest, WithoutAllowedOriginsNothingIsAdded) {
  start();
  const Response response = get("/", kPage);
  expect_not_shared(response, "/");
  EXPECT_EQ(value(response, "vary"), "");
}

TEST_F(CrossOriginTest, APreflightSaysWhatMayBeSent) {
  start_sharing();
  const std::string asks = std::string(kPage) +
                           "Access-Control-Request-Method: POST\r\n"
                           "Access-Control-Request-Headers: authorization,content-type\r\n";
  for (const char* const target :
       {"/kerf.v1.SheetService/ListSheets", "/sheets?format=obj", "/meshes?format=obj", "/sheets/a.png", "/login"}) {
    const Response response = request(port_, "OPTIONS", target, asks);
    EXPECT_EQ(response.status, 204);
    EXPECT_TRUE(response.body.empty());
    expect_shared(response, target);
    EXPECT_EQ(value(response, "access-control-allow-methods"), "GET, HEAD, POST");
    EXPECT_EQ(value(response, "access-control-allow-headers"), "authorization, content-type, x-kerf-csrf");
    EXPECT_EQ(value(response, "access-control-max-age"), "7200");
    EXPECT_EQ(value(response, "access-control-allow-private-network"), "");
  }
  const Response local = request(port_, "OPTIONS", "/", asks + "Access-Control-Request-Private-Network: true\r\n");
  EXPECT_EQ(value(local, "access-control-allow-private-network"), "true");
}

TEST_F(CrossOriginTest, APreflightOfAnotherPageIsRefused) {
  start_sharing();
  const Response refused = request(port_, "OPTIONS", "/kerf.v1.SheetService/ListSheets",
                                   std::string(kOther) + "Access-Control-Request-Method: POST\r\n");
  EXPECT_EQ(refused.status, 403);
  EXPECT_NE(refused.body.find("ORIGIN_NOT_ALLOWED"), std::string::npos) << refused.body;
  expect_not_shared(refused, "preflight");
  const Response plain = request(port_, "OPTIONS", "/");
  EXPECT_EQ(plain.status, 204);
  EXPECT_EQ(value(plain, "allow"), "GET, HEAD, OPTIONS, POST");
  expect_not_shared(plain, "plain");
}

TEST_F(CrossOriginTest, AConnectionIsKeptAfterAPreflight) {
  start_sharing();
  RawClient client(port_);
  ASSERT_TRUE(client.send("OPTIONS / HTTP/1.1\r\nHost: localhost\r\n" + std::string(kPage) + "\r\n"));
  EXPECT_EQ(client.read_response(true).status, 204);
  ASSERT_TRUE(client.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  const Response next = client.read_response();
  EXPECT_EQ(next.body, "ok\n");
  EXPECT_EQ(value(next, "access-control-allow-origin"), "") << "of a request without an origin";
}

TEST(AllowedOrigins, AreComparedAsOrigins) {
  ws::AccessPolicy policy;
  policy.allowed_origins = {"HTTP://LocalHost:3000/", "https://viewer.example.org:443"};
  EXPECT_TRUE(ws::lists_origin(policy, "http://localhost:3000"));
  EXPECT_TRUE(ws::lists_origin(policy, "https://viewer.example.org"));
  for (const char* const other : {"https://localhost:3000", "http://localhost", "http://viewer.example.org", "null", "",
                                  "https://viewer.example.org.evil.org", "http://localhost:3000.evil.org"}) {
    EXPECT_FALSE(ws::lists_origin(policy, other)) << other;
  }
  for (const char* const wrong : {"*", "null", "localhost:3000", "http://a/b", "ftp://a", ""}) {
    EXPECT_NE(ws::fault_of_origin(wrong), "") << wrong;
  }
  EXPECT_EQ(ws::fault_of_origin("http://[::1]:3000"), "");
}

}  // namespace
}  // namespace kerf::ws_test
