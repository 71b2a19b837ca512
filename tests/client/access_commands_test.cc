// `kerf open` and `kerf access`, and the options with which any command shows who calls.

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/connect.h"
#include "client/cli/server_names.h"
#include "tests/client/asking_server.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_authority.h"

namespace kerf::cli {
namespace {

using client_test::AskingServer;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Ran {
  int code = 0;
  std::string out;
  std::string err;
};

// Parses a command line and does what it says.
Ran run_kerf(const std::string& server, std::vector<std::string> words) {
  Session session;
  session.server.address = server;
  const auto app = make_app(session);
  std::reverse(words.begin(), words.end());  // CLI11 takes them from the back.
  Ran ran;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  try {
    app->parse(words);
    ran.code = session.action();
  } catch (const client::CallFailed& refused) {
    ran.code = refuse(refused.failure, session.server);
  } catch (const CLI::ParseError&) {
    ran.code = kWrongUsage;
  }
  ran.out = testing::internal::GetCapturedStdout();
  ran.err = testing::internal::GetCapturedStderr();
  return ran;
}

class AccessCommandsTest : public testing::Test {
 protected:
  AccessCommandsTest() {
    unsetenv("KERF_VIEWER");
    server_.access.set_asks_for_tokens(true);
    server_.access.set_token_id("laptop");
    server_.access.set_scope(v1::SCOPE_CUT);
    server_.access.set_sheets("demo-*");
  }
  ~AccessCommandsTest() override { unsetenv("KERF_VIEWER"); }
  Ran run(const std::vector<std::string>& words) { return run_kerf(server_.address(), words); }

  AskingServer server_;
};

TEST_F(AccessCommandsTest, AccessSaysWhatTheTokenAllows) {
  EXPECT_EQ(run({"access"}).out, "token laptop: scope cut, sheets demo-*, for good\n");
  server_.access.set_expires_unix_s(1'800'000'000);
  EXPECT_THAT(run({"access"}).out, HasSubstr(", until 2027-01-1"));
  const nlohmann::json all = nlohmann::json::parse(run({"--json", "access"}).out);
  EXPECT_EQ(all["scope"], "SCOPE_CUT");
  EXPECT_EQ(all["expires_unix_s"], 1'800'000'000);
  server_.access.Clear();
  EXPECT_EQ(run({"access"}).out,
            server_.address() + " asks for no token: everybody who reaches it may do everything\n");
}

TEST_F(AccessCommandsTest, OpenIsForTheCallerOnceWithTheCallersRights) {
  const Ran ran = run({"open", "demo"});
  EXPECT_EQ(ran.out, "http://127.0.0.1:8080/?sheet=demo#code=abc\n");
  EXPECT_THAT(ran.err, HasSubstr("opens once, within 60 s; the login ends at 2027-01-1"));
  EXPECT_EQ(server_.link_request.scope(), v1::SCOPE_CUT);
  EXPECT_EQ(server_.link_request.sheet_id(), "demo");
  EXPECT_EQ(server_.link_request.lifetime_s(), 0);
  EXPECT_TRUE(server_.link_request.once());
  EXPECT_EQ(run({"-q", "open", "--once"}).err, "");
  EXPECT_EQ(server_.link_request.sheet_id(), "");
  EXPECT_TRUE(server_.link_request.once());
}

TEST_F(AccessCommandsTest, ALastingLinkIsForOthersAndShowsAlone) {
  const Ran ran = run({"open", "demo", "--lasting", "--hours", "0.5"});
  EXPECT_THAT(ran.err, HasSubstr("opens any number of times; "));
  EXPECT_EQ(server_.link_request.scope(), v1::SCOPE_VIEW);
  EXPECT_EQ(server_.link_request.lifetime_s(), 1800);
  EXPECT_FALSE(server_.link_request.once());
  EXPECT_EQ(server_.calls().count("/kerf.v1.AccessService/GetAccess"), 0U);
  run({"open", "--lasting", "--scope", "admin"});
  EXPECT_EQ(server_.link_request.scope(), v1::SCOPE_ADMIN);
  run({"open", "--scope", "view"});
  EXPECT_EQ(server_.link_request.scope(), v1::SCOPE_VIEW);
}

TEST_F(AccessCommandsTest, TheViewerIsThatOfTheOptionOrTheEnvironment) {
  EXPECT_EQ(run({"open", "--viewer", "https://kerf.example.org//"}).out, "https://kerf.example.org/?sheet=#code=abc\n");
  setenv("KERF_VIEWER", "http://viewer:1", 1);
  EXPECT_EQ(run({"open"}).out, "http://viewer:1/?sheet=#code=abc\n");
  EXPECT_EQ(run({"open", "--viewer", "http://other:2"}).out, "http://other:2/?sheet=#code=abc\n");
  unsetenv("KERF_VIEWER");
  const Ran wrong = run({"open", "--viewer", "kerf.example.org"});
  EXPECT_EQ(wrong.code, kWrongUsage);
  EXPECT_THAT(wrong.err, HasSubstr("\"kerf.example.org\" is no address such as http://"));
  const Ran far = run_kerf("kerf.example.org:50051", {"open"});
  EXPECT_EQ(far.code, kWrongUsage);
  EXPECT_THAT(far.err,
              HasSubstr("give --viewer URL or KERF_VIEWER: the address of the viewer of kerf.example.org:50051"));
}

TEST_F(AccessCommandsTest, WithoutTokensTheAddressAloneIsPrinted) {
  server_.access.Clear();
  server_.access.set_scope(v1::SCOPE_ADMIN);
  EXPECT_EQ(run({"open"}).code, kDone);
  server_.refusal = failed_precondition("NO_TOKENS", "the server asks for none");
  const Ran ran = run({"open", "a&b"});
  EXPECT_EQ(ran.code, kDone);
  EXPECT_EQ(ran.out, "http://127.0.0.1:8080/?sheet=a%26b\n");
  EXPECT_EQ(ran.err, "");
  EXPECT_EQ(run({"open", "--lasting"}).out, "http://127.0.0.1:8080/\n");
  const nlohmann::json json = nlohmann::json::parse(run({"--json", "open"}).out);
  EXPECT_EQ(json["url"], "http://127.0.0.1:8080/");
  EXPECT_TRUE(json["expires_unix_s"].is_null());
}

TEST_F(AccessCommandsTest, JsonHasTheAddressAndItsEnd) {
  const Ran ran = run({"--json", "open", "demo"});
  EXPECT_EQ(nlohmann::json::parse(ran.out)["url"], "http://127.0.0.1:8080/?sheet=demo#code=abc");
  EXPECT_EQ(nlohmann::json::parse(ran.out)["expires_unix_s"], 1'800'000'000);
  EXPECT_EQ(ran.err, "");
}

TEST_F(AccessCommandsTest, WrongUsage) {
  for (const char* hours : {"0", "0.01", "169", "nan", "-1", "1e300"}) {
    EXPECT_EQ(run({"open", "--hours", hours}).code, kWrongUsage) << hours;
  }
  EXPECT_EQ(run({"open", "--scope", "all"}).code, kWrongUsage);
  EXPECT_EQ(run({"open", "--once", "--lasting"}).code, kWrongUsage);
  EXPECT_THAT(server_.calls(), IsEmpty());
}

TEST_F(AccessCommandsTest, RefusalsEndWithOneAndTheirNames) {
  server_.refusal = unauthenticated("TOKEN_MISSING", "the server asks for a token");
  for (const std::vector<std::string>& words : {std::vector<std::string>{"access"}, {"open"}, {"open", "--lasting"}}) {
    const Ran ran = run(words);
    EXPECT_EQ(ran.code, kRefused);
    EXPECT_EQ(ran.out, "");
    EXPECT_THAT(ran.err,
                HasSubstr("the server asks for a token (UNAUTHENTICATED, TOKEN_MISSING); give it with --token-file "
                          "FILE or KERF_TOKEN_FILE"));
  }
  server_.refusal = permission_denied("SCOPE_TOO_LOW", "the token may not do that");
  EXPECT_EQ(run({"open", "--scope", "admin"}).err,
            "kerf: the token may not do that (PERMISSION_DENIED, SCOPE_TOO_LOW)\n");
}

TEST_F(AccessCommandsTest, EveryCommandSendsTheToken) {
  const test::TemporaryFolder folder;
  const std::string token = folder.write("token", "kerf_a_b\n");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"info", "--token-file", token}, {"--token-file", token, "undo", "demo"}}) {
    EXPECT_EQ(run(words).code, kRefused) << "UNIMPLEMENTED";
  }
  sheet_ids({server_.address(), {.token_file = token}});
  material_presets({server_.address(), {.token_file = token}});
  EXPECT_THAT(server_.calls().at("/kerf.v1.CutService/UndoCut"), ElementsAre("Bearer kerf_a_b"));
  EXPECT_THAT(server_.calls().at("/kerf.v1.ServerService/GetServerInfo"),
              ElementsAre("Bearer kerf_a_b", "Bearer kerf_a_b"));
  EXPECT_THAT(server_.calls().at("/kerf.v1.SheetService/ListSheets"), ElementsAre("Bearer kerf_a_b"));
}

TEST_F(AccessCommandsTest, CredentialsThatCannotBeUsedAreRefusedByTheirOption) {
  const test::TemporaryFolder folder;
  const std::string missing = folder / "missing";
  const Ran ran = run({"--token-file", missing, "info"});
  EXPECT_EQ(ran.code, kRefused);
  EXPECT_THAT(ran.err,
              HasSubstr("No such file or directory [field: --token-file] (INVALID_ARGUMENT, CREDENTIALS_UNREADABLE)"));
  EXPECT_THAT(run({"--tls-cert", missing, "info"}).err, HasSubstr("without its key [field: --tls-key]"));
  EXPECT_THAT(run({"--tls-key", missing, "load"}).err, HasSubstr("without its certificate [field: --tls-cert]"));
  const std::string token = folder.write("token", "kerf_secret_secret");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"info"}, {"load"}, {"load", "--server", server_.address(), "--http", "10.0.0.1:1"}}) {
    std::vector<std::string> with_token = words;
    with_token.insert(with_token.end(), {"--token-file", token});
    const Ran far = run_kerf("10.0.0.1:50051", with_token);
    EXPECT_EQ(far.code, kRefused);
    EXPECT_THAT(far.err, HasSubstr("in the clear"));
    EXPECT_THAT(far.err, testing::Not(HasSubstr("secret")));
  }
  EXPECT_THAT(sheet_ids({server_.address(), {.token_file = missing}}), IsEmpty());
  EXPECT_THAT(server_.calls(), IsEmpty());
}

TEST(CredentialOptions, TlsReachesTheServer) {
  const test::TestAuthority authority;
  const auto [certificate, key] = authority.make("server");
  grpc::SslServerCredentialsOptions options;
  options.pem_key_cert_pairs.push_back({authority.content_of(key), authority.content_of(certificate)});
  AskingServer server(grpc::SslServerCredentials(options));
  const Ran ran = run_kerf(server.address(), {"open", "--tls-ca", authority.ca()});
  EXPECT_EQ(ran.out, "https://127.0.0.1:8080/?sheet=#code=abc\n");
  const Ran untrusted = run_kerf(server.address(), {"access", "--tls"});
  EXPECT_EQ(untrusted.code, kRefused);
  EXPECT_THAT(untrusted.err, HasSubstr("(UNAVAILABLE, TLS_FAILED)"));
  EXPECT_THAT(run_kerf(server.address(), {"access"}).err, HasSubstr("a server that asks for TLS (--tls-ca)"));
}

}  // namespace
}  // namespace kerf::cli
