// Tokens and TLS: what clients send, what they trust, and what they refuse to send.

#include "client/cpp/credentials.h"

#include <chrono>
#include <future>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cpp/image_watcher.h"
#include "client/cpp/server.h"
#include "client/cpp/transfers.h"
#include "client/cpp/watcher.h"
#include "tests/client/asking_server.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_authority.h"

namespace kerf::client {
namespace {

using client_test::AskingServer;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kToken = "kerf_laptop_0123456789";
constexpr const char* kBearer = "Bearer kerf_laptop_0123456789";

TEST(Tokens, AreCarriedByEveryKindOfCall) {
  const AskingServer server;
  Client client(server.address(), {.token = kToken});
  v1::ServerInfo info;
  v1::Sheet sheet;
  std::string file;
  client.call(&v1::ServerService::Stub::GetServerInfo, client.server(), v1::GetServerInfoRequest(), info);
  upload_sheet(client, v1::CreateSheetRequest(), "v 0 0 0", sheet);
  replay_recording(client, "a", true, "recording", sheet);
  fetch_recording(client, "sheets/a", file);
  Watcher(client).run("sheets/a", {}, [](const auto& /*frame*/, const auto& /*mirror*/) { return true; });
  ImageWatcher(client).run("sheets/a", {}, [](const auto& /*image*/) { return true; });
  std::promise<void> answered;
  grpc::ClientContext context;
  const v1::CreateCutRequest cut;
  v1::CutResult result;
  client.cuts().async()->CreateCut(&context, &cut, &result, [&](const grpc::Status& /*s*/) { answered.set_value(); });
  answered.get_future().wait();
  Server same(server.address(), {.credentials = {.token = kToken}});
  EXPECT_EQ(
      same.sheet("a").subscribe([](const auto& /*frame*/, const auto& /*mirror*/) { return true; }).failure().code,
      grpc::StatusCode::UNIMPLEMENTED);

  const auto calls = server.calls();
  EXPECT_EQ(calls.size(), 8U);
  for (const auto& [method, authorization] : calls) EXPECT_THAT(authorization, ElementsAre(kBearer)) << method;
}

TEST(Tokens, AreNotSentWhereNoneIsGiven) {
  const AskingServer server;
  EXPECT_TRUE(Server(server.address()).access().ok());
  EXPECT_THAT(server.calls().at("/kerf.v1.AccessService/GetAccess"), IsEmpty());
}

TEST(Tokens, ARefusalSaysWhoIsNotKnownOrNotAllowed) {
  AskingServer server;
  Server client(server.address());
  server.refusal = unauthenticated("TOKEN_MISSING", "no token");
  EXPECT_EQ(describe(client.access().failure()), "no token (UNAUTHENTICATED, TOKEN_MISSING)");
  server.refusal = permission_denied("SCOPE_TOO_LOW", "too much");
  EXPECT_EQ(describe(client.create_link().failure()), "too much (PERMISSION_DENIED, SCOPE_TOO_LOW)");
}

TEST(Tokens, LinksHaveWhatWasAskedFor) {
  AskingServer server;
  server.access.set_token_id("laptop");
  Server client(server.address(), {.credentials = {.token = kToken}});
  EXPECT_EQ(client.access().value().token_id(), "laptop");
  EXPECT_EQ(client.create_link().value().path(), "/?sheet=#code=abc");
  EXPECT_EQ(server.link_request.scope(), v1::SCOPE_VIEW);
  EXPECT_EQ(server.link_request.lifetime_s(), 0);
  EXPECT_TRUE(client.create_link({v1::SCOPE_CUT, "demo", std::chrono::minutes(5), true}).ok());
  EXPECT_EQ(server.link_request.scope(), v1::SCOPE_CUT);
  EXPECT_EQ(server.link_request.sheet_id(), "demo");
  EXPECT_EQ(server.link_request.lifetime_s(), 300);
  EXPECT_TRUE(server.link_request.once());
  EXPECT_TRUE(client.create_link({.lifetime = std::chrono::hours(10'000'000)}).ok());
  EXPECT_EQ(server.link_request.lifetime_s(), 2'147'483'647) << "too long, and not a negative number";
}

Failure unusable_by(const Credentials& credentials, const std::string& address = "127.0.0.1:1") {
  const Result<Secrets> secrets = read_secrets(credentials, address);
  EXPECT_FALSE(secrets.ok());
  const Failure failure = secrets ? Failure() : secrets.failure();
  EXPECT_EQ(failure.code, grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(describe(failure), Not(HasSubstr("secret")));
  EXPECT_THROW(Client(address, credentials), CallFailed);
  EXPECT_THROW(Server(address, {.credentials = credentials}), CallFailed);
  return failure;
}

TEST(Tokens, OfAFileAreOneLine) {
  const test::TemporaryFolder folder;
  const std::string token = folder.write("token", "\n \tkerf_a_b \r\n");
  EXPECT_EQ(read_secrets({.token_file = token}, "127.0.0.1:1").value().token, "kerf_a_b");
  EXPECT_EQ(read_secrets({.token = " kerf_a_b "}, "127.0.0.1:1").value().token, "kerf_a_b");
  struct Case {
    std::string content;
    const char* words;
  };
  for (const Case& wrong : {Case{"", "empty"}, Case{" \r\n", "empty"}, Case{"secret\nsecret\n", "more than one line"},
                            Case{"secret\xc3\xa9", "printable ASCII"}, Case{std::string("sec\0ret", 7), "printable"},
                            Case{"a\x7f"
                                 "secret",
                                 "printable"}}) {
    const Failure failure = unusable_by({.token_file = folder.write("wrong", wrong.content)});
    EXPECT_EQ(failure.reason, "TOKEN_MALFORMED");
    EXPECT_EQ(failure.field, "token_file");
    EXPECT_THAT(failure.message, HasSubstr(wrong.words));
  }
  EXPECT_EQ(unusable_by({.token = " \n"}).field, "token");
  EXPECT_EQ(unusable_by({.token = "secret", .token_file = token}).reason, "TOKEN_GIVEN_TWICE");
}

TEST(Tokens, OfAFileThatCannotBeReadSayWhy) {
  const test::TemporaryFolder folder;
  const Failure missing = unusable_by({.token_file = folder / "missing"});
  EXPECT_EQ(missing.reason, "CREDENTIALS_UNREADABLE");
  EXPECT_EQ(missing.field, "token_file");
  EXPECT_THAT(missing.message, HasSubstr("missing\": No such file or directory"));
  EXPECT_THAT(unusable_by({.token_file = folder.path()}).message, HasSubstr("Is a directory"));
  EXPECT_THAT(unusable_by({.token_file = "/dev/zero"}).message, HasSubstr("more than 4096 bytes"));
}

TEST(Tokens, LeaveThisMachineThroughTlsAlone) {
  const std::string far = "kerf.example.org:50051";
  const test::TemporaryFolder folder;
  const Failure failure = unusable_by({.token = "kerf_secret"}, far);
  EXPECT_EQ(failure.reason, "TOKEN_NEEDS_TLS");
  EXPECT_EQ(failure.field, "token");
  EXPECT_THAT(failure.message, HasSubstr("not sent to kerf.example.org:50051 in the clear"));
  EXPECT_THAT(failure.message, HasSubstr("use TLS"));
  EXPECT_EQ(unusable_by({.token_file = folder.write("token", "secret")}, far).field, "token_file");
  EXPECT_TRUE(read_secrets({.token = "kerf_secret", .use_tls = true}, far).ok());
  EXPECT_TRUE(read_secrets({}, far).ok());
}

TEST(Tokens, AddressesOfThisMachine) {
  for (const char* here :
       {"127.0.0.1:1", "127.9.8.7", "[::1]:1", "::1", "localhost:1", "LocalHost", "unix:/run/kerf",
        "unix-abstract:kerf", "dns:///localhost:1", "dns:localhost", "ipv4:127.0.0.1:1,127.0.0.2:1", "ipv6:[::1]:1"}) {
    EXPECT_TRUE(is_on_this_machine(here)) << here;
  }
  for (const char* far : {"", "128.0.0.1:1", "0.0.0.0:1", "[::]:1", "[fe80::1]:1", "localhost.example.org:1",
                          "127.0.0.1.example.org:1", "dns://8.8.8.8/localhost:1", "ipv4:127.0.0.1:1,10.0.0.1:1",
                          "ipv4:", "localhost:1,evil:2", "127.1:1", "[::1", "[127.0.0.1]evil"}) {
    EXPECT_FALSE(is_on_this_machine(far)) << far;
  }
}

class TlsTest : public testing::Test {
 protected:
  [[nodiscard]] std::shared_ptr<grpc::ServerCredentials> credentials(const test::TestAuthority::Pair& pair,
                                                                     bool asks_for_certificates = false) const {
    grpc::SslServerCredentialsOptions options;
    options.pem_key_cert_pairs.push_back({authority_.content_of(pair.key), authority_.content_of(pair.certificate)});
    if (asks_for_certificates) {
      options.pem_root_certs = authority_.content_of(authority_.ca());
      options.client_certificate_request = GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY;
    }
    return grpc::SslServerCredentials(options);
  }
  // Calls, and returns why that was refused.
  static Failure refused(const AskingServer& server, const Credentials& with) {
    const Result<v1::Access> access =
        Server(server.address(), {.timeout = std::chrono::seconds(20), .credentials = with}).access();
    EXPECT_FALSE(access.ok());
    EXPECT_THAT(server.calls(), IsEmpty());
    return access ? Failure() : access.failure();
  }

  const test::TestAuthority authority_;
};

TEST_F(TlsTest, CallsAreEncryptedAndCarryTheToken) {
  const AskingServer server(credentials(authority_.make("server")));
  Server client(server.address(), {.credentials = {.token = kToken, .tls_ca = authority_.ca()}});
  EXPECT_TRUE(client.access().ok());
  Watcher watcher(client.client());
  watcher.run("sheets/a", {}, [](const auto& /*frame*/, const auto& /*mirror*/) { return true; });
  EXPECT_THAT(server.calls().at("/kerf.v1.AccessService/GetAccess"), ElementsAre(kBearer));
  EXPECT_THAT(server.calls().at("/kerf.v1.StreamService/Watch"), ElementsAre(kBearer));
}

TEST_F(TlsTest, AServerOfAnotherAuthorityIsNotTrusted) {
  const AskingServer server(credentials(authority_.make("server")));
  const Failure of_system = refused(server, {.token = kToken, .use_tls = true});
  EXPECT_EQ(of_system.reason, "TLS_FAILED");
  EXPECT_THAT(of_system.message, HasSubstr("of another authority"));
  const test::TestAuthority other;
  EXPECT_EQ(refused(server, {.token = kToken, .tls_ca = other.ca()}).reason, "TLS_FAILED");
}

TEST_F(TlsTest, AServerWithAnotherNameIsTrustedIfThatIsGiven) {
  const AskingServer server(credentials(authority_.make("elsewhere", "DNS:kerf.example.org")));
  EXPECT_EQ(refused(server, {.token = kToken, .tls_ca = authority_.ca()}).reason, "TLS_FAILED");
  Server client(server.address(),
                {.credentials = {.token = kToken, .tls_ca = authority_.ca(), .tls_name = "kerf.example.org"}});
  EXPECT_TRUE(client.access().ok());
}

TEST_F(TlsTest, AServerWithoutTlsGetsNoToken) {
  const AskingServer server;
  EXPECT_EQ(refused(server, {.token = kToken, .tls_ca = authority_.ca()}).reason, "TLS_FAILED");
}

TEST_F(TlsTest, AServerThatAsksForACertificateGetsOne) {
  const AskingServer server(credentials(authority_.make("server"), true));
  EXPECT_EQ(refused(server, {.tls_ca = authority_.ca()}).code, grpc::StatusCode::UNAVAILABLE);
  const auto [certificate, key] = authority_.make("client");
  Server client(server.address(),
                {.credentials = {.tls_ca = authority_.ca(), .tls_cert = certificate, .tls_key = key}});
  EXPECT_TRUE(client.access().ok());
}

TEST_F(TlsTest, FilesThatCannotBeUsedSayWhy) {
  const auto [certificate, key] = authority_.make("client");
  const test::TemporaryFolder folder;
  const std::string locked = folder.write("locked", "-----BEGIN ENCRYPTED PRIVATE KEY-----\n");
  struct Case {
    Credentials credentials;
    const char* reason;
    const char* field;
    const char* words;
  };
  for (const Case& wrong :
       {Case{{.tls_cert = certificate}, "TLS_PAIR_INCOMPLETE", "tls_key", "a certificate is given without its key"},
        Case{{.tls_key = key}, "TLS_PAIR_INCOMPLETE", "tls_cert", "a key is given without its certificate"},
        Case{{.tls_ca = folder / "missing"}, "CREDENTIALS_UNREADABLE", "tls_ca", "No such file"},
        Case{{.tls_ca = key}, "TLS_FILE_MALFORMED", "tls_ca", "has no CERTIFICATE"},
        Case{{.tls_cert = key, .tls_key = key}, "TLS_FILE_MALFORMED", "tls_cert", "has no CERTIFICATE"},
        Case{{.tls_cert = certificate, .tls_key = certificate}, "TLS_FILE_MALFORMED", "tls_key", "has no PRIVATE KEY"},
        Case{{.tls_cert = certificate, .tls_key = locked}, "TLS_FILE_MALFORMED", "tls_key", "without a password"}}) {
    const Failure failure = unusable_by(wrong.credentials);
    EXPECT_EQ(failure.reason, wrong.reason);
    EXPECT_EQ(failure.field, wrong.field);
    EXPECT_THAT(failure.message, HasSubstr(wrong.words));
  }
}

TEST_F(TlsTest, IsUsedWhereAnAuthorityOrACertificateIsGiven) {
  const auto [certificate, key] = authority_.make("client");
  EXPECT_FALSE(read_secrets({}, "a:1").value().use_tls);
  EXPECT_TRUE(read_secrets({.use_tls = true}, "a:1").value().use_tls);
  EXPECT_TRUE(read_secrets({.tls_ca = authority_.ca()}, "a:1").value().use_tls);
  EXPECT_TRUE(read_secrets({.tls_cert = certificate, .tls_key = key}, "a:1").value().use_tls);
}

}  // namespace
}  // namespace kerf::client
