// gRPC over TLS, with and without certificates of clients.

#include <gtest/gtest.h>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>
#include <openssl/ssl.h>

#include <memory>
#include <string>

#include "client/cpp/client.h"
#include "kerf/v1/server.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "kerf/v1/stream.grpc.pb.h"
#include "tests/support/certificates.h"
#include "tests/support/temporary_folder.h"
#include "tests/ws/raw_client.h"
#include "tests/ws/running_server.h"
#include "tests/ws/tls_client.h"

namespace kerf::rpc_test {
namespace {

using ws_test::TlsClient;
using ws_test::TlsOffer;

class RpcTlsTest : public ::testing::Test {
 protected:
  void serve(const std::string& client_authorities = "") {
    app::Config config = ws_test::test_config();
    config.tls.certificate = folder_.write("server.pem", own_.certificate).string();
    config.tls.key = folder_.write("server.key", own_.key).string();
    if (!client_authorities.empty()) {
      config.tls.client_authorities = folder_.write("clients.pem", client_authorities).string();
    }
    server_ = ws_test::start_server(config);
    ASSERT_NE(server_, nullptr);
    port_ = ws_test::port_of(server_->grpc_address());
  }

  // Names no host: c-ares 1.18, which looks names up for gRPC on Debian 12, leaks those that /etc/hosts has.
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  // A channel that trusts `authority`, expects a certificate of localhost, and shows `identity`, if it has a key.
  [[nodiscard]] std::shared_ptr<grpc::Channel> channel(const test::Authority& authority,
                                                       const test::Identity& identity = {}) const {
    grpc::ChannelArguments arguments;
    arguments.SetSslTargetNameOverride("localhost");
    return grpc::CreateCustomChannel(
        address(), grpc::SslCredentials({authority.certificate(), identity.key, identity.certificate}), arguments);
  }
  // Asks for the server's information once.
  [[nodiscard]] static grpc::Status ask(const std::shared_ptr<grpc::Channel>& channel) {
    client::Client client(channel);
    v1::ServerInfo info;
    return client.call(&v1::ServerService::Stub::GetServerInfo, client.server(), v1::GetServerInfoRequest(), info);
  }
  [[nodiscard]] TlsOffer offer() const { return {.authority = authority_.certificate(), .alpn = {"h2"}}; }

  const test::TemporaryFolder folder_;
  const test::Authority authority_{"Kerf test authority"};
  const test::Authority other_{"Another authority"};
  const test::Identity own_ = authority_.issue("localhost");
  std::unique_ptr<app::Server> server_;
  int port_ = 0;
};

TEST_F(RpcTlsTest, AnswersCallsAndStreams) {
  serve();
  const std::shared_ptr<grpc::Channel> trusted = channel(authority_);
  client::Client client(trusted);
  v1::CreateSheetRequest request;
  request.set_sheet_id("a");
  request.set_paused(true);
  v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
  grid.set_columns(60);
  grid.set_rows(60);
  grid.set_width_m(1.0);
  grid.set_height_m(1.0);
  v1::Sheet sheet;
  const grpc::Status made = client.call(&v1::SheetService::Stub::CreateSheet, client.sheets(), request, sheet);
  ASSERT_TRUE(made.ok()) << made.error_message();
  grpc::ClientContext context;
  const auto stub = v1::StreamService::NewStub(trusted);
  const auto stream = stub->Watch(&context);
  v1::WatchRequest start;
  start.mutable_start()->set_name("sheets/a");
  ASSERT_TRUE(stream->Write(start));
  v1::WatchResponse response;
  ASSERT_TRUE(stream->Read(&response));
  EXPECT_TRUE(response.has_frame());
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(RpcTlsTest, IsRefusedByWhoeverDoesNotTrustIt) {
  serve();
  EXPECT_EQ(ask(channel(other_)).error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(ask(grpc::CreateChannel(address(), grpc::InsecureChannelCredentials())).error_code(),
            grpc::StatusCode::UNAVAILABLE);
  ws_test::RawClient plain(port_);
  plain.send("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n");
  EXPECT_EQ(plain.read_rest().find("HTTP"), std::string::npos);
}

TEST_F(RpcTlsTest, SpeaksTls13AndTls12WithKeysOfTheMomentAlone) {
  serve();
  EXPECT_EQ(TlsClient(port_, offer()).version(), "TLSv1.3");
  const auto failure = [this](int version, const std::string& ciphers) {
    TlsOffer only = offer();
    only.version = version;
    only.ciphers = ciphers;
    return TlsClient(port_, only).failure();
  };
  EXPECT_EQ(failure(TLS1_2_VERSION, "ECDHE-ECDSA-AES128-GCM-SHA256"), "");
  for (const char* bad : {"ECDHE-ECDSA-NULL-SHA", "ECDHE-ECDSA-AES128-SHA", "AECDH-AES128-SHA"}) {
    EXPECT_NE(failure(TLS1_2_VERSION, bad), "") << bad;
  }
  EXPECT_NE(failure(TLS1_1_VERSION, "ALL:@SECLEVEL=0"), "");
}

TEST_F(RpcTlsTest, AHandshakeHasItsTime) {
  serve();
  ws_test::RawClient stalled(port_);
  stalled.send(std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc", 9));  // The first bytes of a ClientHello.
  EXPECT_TRUE(stalled.closed_by_peer());
}

TEST_F(RpcTlsTest, AClientNeedsACertificateOfTheAuthority) {
  serve(authority_.certificate());
  EXPECT_TRUE(ask(channel(authority_, authority_.issue("client"))).ok());
  EXPECT_EQ(ask(channel(authority_)).error_code(), grpc::StatusCode::UNAVAILABLE) << "none";
  EXPECT_EQ(ask(channel(authority_, other_.issue("client"))).error_code(), grpc::StatusCode::UNAVAILABLE)
      << "of another authority";
  const test::Identity expired = authority_.issue("client", {.begin_s = -7200, .end_s = -3600});
  EXPECT_EQ(ask(channel(authority_, expired)).error_code(), grpc::StatusCode::UNAVAILABLE) << "expired";
}

TEST_F(RpcTlsTest, AClientWithoutACertificateHearsNothingOfHttp2) {
  serve(authority_.certificate());
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
    TlsOffer good = offer();
    good.version = version;
    good.identity = authority_.issue("client");
    TlsClient known(port_, good);
    known.send("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n");
    EXPECT_TRUE(known.read_exactly(9)) << "the head of its SETTINGS";
    for (const test::Identity& bad : {test::Identity(), other_.issue("client")}) {
      TlsOffer stranger = good;
      stranger.identity = bad;
      TlsClient unknown(port_, stranger);
      unknown.send("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n");
      EXPECT_EQ(unknown.read_rest(), "");
    }
  }
}

}  // namespace
}  // namespace kerf::rpc_test
