// Tokens, logins and links over HTTP.

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "server/service/auth/token_file.h"
#include "tests/ws/http_fixture.h"

namespace kerf::ws_test {
namespace {

std::string bearer(const auth::NewToken& token) {
  return "Authorization: Bearer " + token.text + "\r\n";
}

class LoginTest : public HttpServerTest {
 protected:
  LoginTest() {
    config_.tokens = folder_.write("tokens", admin_.line + "\n" + viewer_of_a_.line + "\n");
    start(config_);
    EXPECT_EQ(call("SheetService/CreateSheet", kSheet, bearer(admin_)).status, 200);
  }
  [[nodiscard]] Response post(std::string_view target, std::string_view json, std::string_view headers = {}) const {
    return request(port_, "POST", target, headers, json);
  }
  // Logs in and returns the header line with the cookie.
  [[nodiscard]] std::string log_in(const std::string& json) const {
    const Response response = post("/login", json);
    EXPECT_EQ(response.status, 200) << response.body;
    const auto cookie = response.headers.find("set-cookie");
    if (cookie == response.headers.end()) return {};
    EXPECT_NE(cookie->second.find("; HttpOnly; SameSite=Strict"), std::string::npos) << cookie->second;
    return "Cookie: other=1; " + cookie->second.substr(0, cookie->second.find(';')) + "\r\n";
  }
  [[nodiscard]] std::string log_in(const auth::NewToken& token) const {
    return log_in(R"({"token":")" + token.text + R"("})");
  }
  [[nodiscard]] std::string origin() const { return "Origin: http://127.0.0.1:" + std::to_string(port_) + "\r\n"; }
  // The answer to a handshake of a WebSocket at `path`.
  [[nodiscard]] Response handshake(std::string_view path, const std::string& headers) const {
    return request(port_, "GET", path,
                   "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                   "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: kerf.v1\r\n" +
                       headers);
  }
  static void expect_refused(const Response& response, int status, const std::string& reason) {
    EXPECT_EQ(response.status, status) << reason;
    EXPECT_NE(response.body.find(reason), std::string::npos) << response.body;
  }

  const auth::NewToken admin_ = auth::make_token({"admin", auth::Scope::kAdmin, "", "", ""}).value();
  const auth::NewToken viewer_of_a_ = auth::make_token({"viewer", auth::Scope::kView, "a", "", ""}).value();
  app::Config config_ = test_config();
};

const std::string kCsrf = "x-kerf-csrf: 1\r\n";
constexpr const char* kGet = R"({"name":"sheets/a"})";

TEST_F(LoginTest, WithoutATokenOnlyThePagesAreOpen) {
  for (const char* const open : {"/", "/assets/app-12.js", "/healthz", "/readyz"}) {
    EXPECT_EQ(get(open).status, 200) << open;
  }
  for (const char* const closed : {"/metrics", "/sheets/a.png", "/sheets/a.mjpeg", "/sheets/a.rec"}) {
    expect_refused(get(closed), 401, "TOKEN_MISSING");
    expect_refused(get(closed, "Authorization: Bearer kerf_admin_x\r\n"), 401, "TOKEN_UNKNOWN");
  }
  for (const char* const closed : {"/sheets?format=obj", "/meshes?format=obj", "/recordings",
                                   "/kerf.v1.SheetService/GetSheet", "/kerf.v1.AccessService/GetAccess"}) {
    const Response response = post(closed, "{}");
    expect_refused(response, 401, "TOKEN_MISSING");
    EXPECT_EQ(response.headers.at("www-authenticate"), "Bearer");
  }
  for (const char* const closed : {"/watch", "/images"}) {
    expect_refused(handshake(closed, ""), 401, "TOKEN_MISSING");
    expect_refused(handshake(closed, "Cookie: kerf=guess\r\n" + origin()), 401, "LOGIN_UNKNOWN");
    EXPECT_EQ(handshake(closed, bearer(admin_)).status, 101);
  }
}

TEST_F(LoginTest, ATokenDoesWhatItsLineSays) {
  EXPECT_EQ(call("SheetService/GetSheet", kGet, bearer(viewer_of_a_)).status, 200);
  expect_refused(call("SheetService/ResetSheet", kGet, bearer(viewer_of_a_)), 403, "SCOPE_TOO_LOW");
  expect_refused(call("SheetService/GetSheet", R"({"name":"sheets/b"})", bearer(viewer_of_a_)), 404, "SHEET_NOT_FOUND");
  expect_refused(get("/metrics", bearer(viewer_of_a_)), 403, "SHEET_NOT_ALLOWED");
  EXPECT_EQ(get("/metrics", bearer(admin_)).status, 200);
  EXPECT_EQ(get("/sheets/a.rec", bearer(viewer_of_a_)).status, 200);
  expect_refused(get("/sheets/b.rec", bearer(viewer_of_a_)), 404, "SHEET_NOT_FOUND");
  expect_refused(post("/sheets?format=obj", "v 0 0 0\n", bearer(viewer_of_a_)), 403, "SCOPE_TOO_LOW");
  expect_refused(post("/meshes?format=obj", "v 0 0 0\n", bearer(viewer_of_a_)), 403, "SCOPE_TOO_LOW");
}

TEST_F(LoginTest, ABrowserLogsInAndOut) {
  const std::string cookie = log_in(viewer_of_a_);
  ASSERT_NE(cookie, "");
  EXPECT_EQ(call("SheetService/GetSheet", kGet, cookie + kCsrf + origin()).status, 200);
  expect_refused(call("SheetService/GetSheet", kGet, cookie + origin()), 403, "CSRF_HEADER_MISSING");
  expect_refused(call("SheetService/GetSheet", kGet, cookie + kCsrf + "Origin: http://evil.example\r\n"), 403,
                 "ORIGIN_NOT_ALLOWED");
  EXPECT_EQ(get("/sheets/a.rec", cookie).status, 200) << "a link of the page";
  EXPECT_EQ(handshake("/watch", cookie + origin()).status, 101);
  expect_refused(handshake("/watch", cookie), 403, "ORIGIN_MISSING");
  expect_refused(handshake("/watch", cookie + "Origin: http://evil.example\r\n"), 403, "ORIGIN_NOT_ALLOWED");
  const Response out = post("/logout", "", cookie + kCsrf + origin());
  EXPECT_EQ(out.status, 200);
  EXPECT_NE(out.headers.at("set-cookie").find("Max-Age=0"), std::string::npos);
  expect_refused(call("SheetService/GetSheet", kGet, cookie + kCsrf), 401, "LOGIN_UNKNOWN");
}

TEST_F(LoginTest, ALinkLogsIn) {
  const Response made = call("AccessService/CreateLink", R"({"sheet_id":"a","once":true})", bearer(admin_));
  ASSERT_EQ(made.status, 200) << made.body;
  const std::size_t begin = made.body.find("\"code\":\"") + 8;
  const std::string code = made.body.substr(begin, 43);
  const std::string json = R"({"code":")" + code + R"("})";
  const std::string cookie = log_in(json);
  EXPECT_EQ(call("SheetService/GetSheet", kGet, cookie + kCsrf).status, 200);
  expect_refused(call("SheetService/DeleteSheet", kGet, cookie + kCsrf), 403, "SCOPE_TOO_LOW");
  expect_refused(post("/login", json), 401, "CODE_UNKNOWN");
}

TEST_F(LoginTest, AddressesInHeadersCountOnlyBehindAProxy) {
  const std::string guess = R"({"token":"kerf_admin_x"})";
  for (int i = 0; i < 10; ++i) {
    const std::string header = "X-Forwarded-For: 192.0.2." + std::to_string(i) + "\r\n";
    expect_refused(post("/login", guess, header), 401, "TOKEN_UNKNOWN");
  }
  expect_refused(post("/login", guess, "X-Forwarded-For: 192.0.2.99\r\n"), 429, "TOO_MANY_LOGINS");
}

class LoginBehindProxyTest : public HttpServerTest {
 protected:
  LoginBehindProxyTest() {
    app::Config config = test_config();
    config.tokens = folder_.write("tokens", admin_.line + "\n");
    config.audit_log = (folder_ / "audit.log").string();
    config.behind_proxy = true;
    start(config);
  }
  // Returns the status of a login through the proxy of a client.
  [[nodiscard]] int log_in(const std::string& address, const std::string& token) const {
    return request(port_, "POST", "/login", "X-Forwarded-For: " + address + "\r\n", R"({"token":")" + token + R"("})")
        .status;
  }

  const auth::NewToken admin_ = auth::make_token({"admin", auth::Scope::kAdmin, "", "", ""}).value();
};

TEST_F(LoginBehindProxyTest, GuessesCountByTheAddressThatTheProxyGives) {
  for (int i = 0; i < 10; ++i) EXPECT_EQ(log_in("192.0.2.7", "guess"), 401);
  EXPECT_EQ(log_in("192.0.2.7", admin_.text), 429);
  EXPECT_EQ(log_in("2001:db8::7", admin_.text), 200);
  EXPECT_EQ(log_in(std::string(46, '1'), "guess"), 401) << "no address: that of the proxy counts";
  const auto has = [this](const std::string& text) {
    std::ifstream file(folder_ / "audit.log");
    return std::string(std::istreambuf_iterator<char>(file), {}).find(text) != std::string::npos;
  };
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!has(R"("address":"2001:db8::7")") && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  EXPECT_TRUE(
      has(R"("call":"Login","outcome":"OK","token_id":"admin","by_link":false,"tenant":"","address":"2001:db8::7")"));
}

TEST_F(LoginTest, GuessesAreSlowedDown) {
  for (const char* const wrong :
       {"", "{}", "[]", R"({"token":{}})", R"({"token":"a","code":"b"})", R"({"secret":"a"})"}) {
    EXPECT_EQ(post("/login", wrong).status, 400) << wrong;
  }
  for (int i = 0; i < 10; ++i) expect_refused(post("/login", R"({"token":"kerf_admin_x"})"), 401, "TOKEN_UNKNOWN");
  const Response late = post("/login", R"({"token":")" + admin_.text + R"("})");
  expect_refused(late, 429, "TOO_MANY_LOGINS");
  EXPECT_EQ(late.headers.at("retry-after"), "60");
  EXPECT_EQ(call("SheetService/GetSheet", kGet, bearer(admin_)).status, 200)
      << "a token in a header is not slowed down";
}

TEST_F(LoginTest, TheFileIsReadAgain) {
  const std::string cookie = log_in(viewer_of_a_);
  folder_.write("tokens", admin_.line + "\n");
  EXPECT_TRUE(server_->reload());
  expect_refused(call("SheetService/GetSheet", kGet, bearer(viewer_of_a_)), 401, "TOKEN_UNKNOWN");
  expect_refused(call("SheetService/GetSheet", kGet, cookie + kCsrf), 401, "TOKEN_UNKNOWN");
  folder_.write("tokens", "nonsense\n");
  EXPECT_TRUE(server_->reload());
  EXPECT_EQ(call("SheetService/GetSheet", kGet, bearer(admin_)).status, 200) << "a wrong file changes nothing";
}

TEST_F(HttpServerTest, WithoutTokensNobodyLogsIn) {
  start();
  const Response login = request(port_, "POST", "/login", "", R"({"token":"x"})");
  EXPECT_EQ(login.status, 400);
  EXPECT_NE(login.body.find("NO_TOKENS"), std::string::npos);
  EXPECT_FALSE(server_->reload());
}

}  // namespace
}  // namespace kerf::ws_test
