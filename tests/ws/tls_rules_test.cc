// Versions and ciphers of TLS, and what becomes of clients that speak none, or not on.

#include <gtest/gtest.h>
#include <openssl/ssl.h>

#include <chrono>
#include <memory>
#include <string>

#include "server/service/ws/tls.h"
#include "tests/support/wait_until.h"
#include "tests/ws/tls_fixture.h"

namespace kerf::ws_test {
namespace {

using std::chrono::milliseconds;

class TlsRulesTest : public TlsTest {
 protected:
  // Returns why the server does not shake hands with a client that offers only this; empty if it does.
  [[nodiscard]] std::string failure(int version, const std::string& ciphers) const {
    TlsOffer only = offer();
    only.version = version;
    only.ciphers = ciphers;
    return TlsClient(port_, only).failure();
  }
};

TEST_F(TlsRulesTest, SpeaksTls13AndTls12WithKeysOfTheMomentAlone) {
  start();
  EXPECT_EQ(connect()->version(), "TLSv1.3");
  for (const char* good :
       {"ECDHE-ECDSA-AES128-GCM-SHA256", "ECDHE-ECDSA-AES256-GCM-SHA384", "ECDHE-ECDSA-CHACHA20-POLY1305"}) {
    EXPECT_EQ(failure(TLS1_2_VERSION, good), "") << good;
  }
  for (const char* bad : {"ECDHE-ECDSA-NULL-SHA", "ECDHE-ECDSA-AES128-SHA", "ECDHE-ECDSA-AES256-SHA384",
                          "ECDHE-ECDSA-AES128-CCM", "AECDH-AES128-SHA"}) {
    EXPECT_EQ(failure(TLS1_2_VERSION, bad), "sslv3 alert handshake failure") << bad;
  }
  for (const int old : {TLS1_VERSION, TLS1_1_VERSION}) {
    EXPECT_EQ(failure(old, "ALL:@SECLEVEL=0"), "tlsv1 alert protocol version");
  }
}

TEST_F(TlsRulesTest, KeepsNoSessionAndBeginsNoneAgain) {
  start();
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
    TlsOffer only = offer();
    only.version = version;
    TlsClient client(port_, only);
    EXPECT_EQ(get(client, "/healthz").status, 200);
    EXPECT_FALSE(client.is_resumable());
  }
  TlsOffer old = offer();
  old.version = TLS1_2_VERSION;
  TlsClient client(port_, old);
  EXPECT_FALSE(client.renegotiate());
}

TEST_F(TlsRulesTest, SpeaksHttp11AndNoOtherProtocol) {
  start();
  TlsOffer browser = offer();
  browser.alpn = {"h2", "http/1.1"};
  TlsClient client(port_, browser);
  EXPECT_EQ(client.protocol(), "http/1.1");
  EXPECT_EQ(get(client, "/healthz").status, 200);
  TlsOffer grpc = offer();
  grpc.alpn = {"h2"};
  EXPECT_EQ(TlsClient(port_, grpc).failure(), "tlsv1 alert no application protocol");
}

TEST_F(TlsRulesTest, PlainHttpIsAnsweredAndAllElseClosed) {
  start();
  for (const char* method : {"GET", "POST"}) {
    const Response plain = request(port_, method, "/healthz");
    EXPECT_EQ(plain.status, 400);
    EXPECT_NE(plain.body.find("TLS_NEEDED"), std::string::npos) << plain.body;
  }
  RawClient garbage(port_);
  garbage.send("\x01\x02garbage that is no record of TLS");
  EXPECT_EQ(garbage.read_rest().find("HTTP"), std::string::npos);
  RawClient gone(port_);
  gone.send("\x16\x03\x01");
  gone.hang_up();
  EXPECT_EQ(ask("GET", "/healthz").status, 200);
}

TEST_F(TlsRulesTest, AHandshakeHasItsTime) {
  app::Config config = test_config();
  config.http_options.request_timeout = milliseconds(100);
  start(config);
  RawClient silent(port_);
  RawClient stalled(port_);
  stalled.send(std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc", 9));  // The first bytes of a ClientHello.
  TlsClient mute(port_, offer());                                        // Shakes hands, and asks for nothing.
  EXPECT_TRUE(silent.closed_by_peer());
  EXPECT_TRUE(stalled.closed_by_peer());
  EXPECT_TRUE(mute.closed_by_peer());
}

TEST_F(TlsRulesTest, ClientsThatDoNotSayGoodbyeHoldNothingUp) {
  start();
  TlsClient client(port_, offer());
  client.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(client.read_response().status, 200);
  EXPECT_TRUE(client.closed_by_peer());
  EXPECT_TRUE(client.was_told_goodbye());
  const std::unique_ptr<TlsClient> asking = connect();
  test::wait_until(
      [&] { return get(*asking, "/metrics").body.find("\nkerf_http_open_connections 1\n") != std::string::npos; });
}

TEST_F(TlsRulesTest, AServerStopsWithClientsInEveryState) {
  start();
  RawClient stalled(port_);
  stalled.send(std::string("\x16\x03\x01\x02\x00", 5));
  const std::unique_ptr<TlsClient> idle = connect();
  EXPECT_EQ(get(*idle, "/healthz").status, 200);
  const auto began = std::chrono::steady_clock::now();
  server_->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(3)) << "the time for work under way";
  EXPECT_TRUE(idle->closed_by_peer());
  EXPECT_TRUE(stalled.closed_by_peer());
}

TEST_F(TlsRulesTest, BeyondItsLimitAnAddressIsClosed) {
  app::Config config = test_config();
  config.max_connections_per_address = 1;
  start(config);
  const std::unique_ptr<TlsClient> first = connect();
  EXPECT_EQ(get(*first, "/healthz").status, 200);
  EXPECT_NE(TlsClient(port_, offer()).failure(), "");
  EXPECT_NE(get(*first, "/metrics").body.find("\nkerf_http_refused_connections_total{limit=\"address\"} 1\n"),
            std::string::npos);
}

TEST_F(TlsRulesTest, AnotherCertificateIsForNewConnections) {
  start();
  const std::unique_ptr<TlsClient> before = connect();
  const test::Authority other("Another authority");
  app::Config config = test_config();
  use(config, other.issue("localhost"));  // The files of the running server.
  EXPECT_TRUE(server_->reload());
  EXPECT_EQ(get(*before, "/healthz").status, 200);
  EXPECT_NE(TlsClient(port_, offer()).failure(), "") << "whoever trusts the first authority alone";
  const TlsOffer trusting{.authority = other.certificate()};
  EXPECT_EQ(TlsClient(port_, trusting).failure(), "");
  folder_.write("server.pem", "nothing");
  EXPECT_TRUE(server_->reload());
  EXPECT_EQ(TlsClient(port_, trusting).failure(), "") << "a wrong file changes nothing";
}

TEST(TlsContext, SaysWhyACertificateIsNotTaken) {
  const test::Authority authority("Kerf test authority");
  const test::Identity one = authority.issue("localhost");
  const test::Identity other = authority.issue("localhost");
  EXPECT_TRUE(ws::TlsContext::make(one.certificate, one.key).ok());
  const auto mixed = ws::TlsContext::make(one.certificate, other.key);
  ASSERT_FALSE(mixed.ok());
  EXPECT_EQ(mixed.error().reason, "BAD_CERTIFICATE");
  EXPECT_NE(mixed.error().message.find("key values mismatch"), std::string::npos) << mixed.error().message;
  EXPECT_FALSE(ws::TlsContext::make(one.certificate, test::with_password(one.key, "secret")).ok());
}

}  // namespace
}  // namespace kerf::ws_test
