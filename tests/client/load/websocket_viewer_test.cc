// Readers over a WebSocket whose server is not as it should be.

#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>

#include "client/load/viewer.h"
#include "tests/support/test_authority.h"

namespace kerf::load {
namespace {

using namespace std::chrono_literals;
using Tcp = boost::asio::ip::tcp;

class WebSocketViewerTest : public testing::Test {
 protected:
  WebSocketViewerTest() {
    plan_.transport = Transport::kWebSocket;
    plan_.http = "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  std::unique_ptr<Viewer> viewer(Role role = Role::kViewer) {
    return watch_frames_over_websocket(plan_, {role, "sheets/a", 0, plan_.http, nullptr}, recorder_, stopper_);
  }

  boost::asio::io_context context_;
  Tcp::acceptor acceptor_{context_, {boost::asio::ip::address_v4::loopback(), 0}};
  Plan plan_;
  Recorder recorder_;
  Stopper stopper_;
};

TEST_F(WebSocketViewerTest, OfAServerThatAcceptsAndSaysNothingEndsWhenItIsStopped) {
  const std::unique_ptr<Viewer> reader = viewer();
  const Tcp::socket silent = acceptor_.accept();
  reader->stop();
}

TEST_F(WebSocketViewerTest, StoppedAtOnceItEnds) {
  viewer()->stop();
}

// One vertex and no triangle.
std::string frame_message() {
  v1::WatchResponse response;
  v1::Frame& frame = *response.mutable_frame();
  frame.set_sequence(1);
  frame.set_base_tick(-1);
  frame.set_topology_version(1);
  frame.set_num_vertices(1);
  frame.set_encoding(v1::RAW);
  frame.mutable_box();
  frame.set_positions(std::string(6, '\0'));
  frame.mutable_topology()->set_base_version(-1);
  frame.mutable_topology()->set_num_listed_vertices(1);
  frame.mutable_topology()->set_material_positions(std::string(8, '\0'));
  return response.SerializeAsString();
}

// While the reader holds its first frame the connection is reset, so that the acknowledgement fails.
TEST_F(WebSocketViewerTest, AnAcknowledgementThatFailsIsAnEnd) {
  plan_.hold_s = 0.3;
  const std::unique_ptr<Viewer> reader = viewer(Role::kSlow);
  {
    boost::beast::websocket::stream<Tcp::socket> server(acceptor_.accept());
    server.accept();
    server.binary(true);
    boost::beast::flat_buffer start;
    server.read(start);
    server.write(boost::asio::buffer(frame_message()));
    while (recorder_.readers(Role::kSlow).readers == 0) std::this_thread::sleep_for(1ms);
    server.next_layer().set_option(boost::asio::socket_base::linger(true, 0));
  }
  while (recorder_.readers(Role::kSlow).ends.empty()) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(recorder_.readers(Role::kSlow).ends.size(), 1U);
}

// Accepts the opening of a WebSocket. Returns the value of its header `Authorization`.
template <typename Stream>
std::string accept_opening(boost::beast::websocket::stream<Stream>& server) {
  boost::beast::flat_buffer buffer;
  boost::beast::http::request<boost::beast::http::string_body> request;
  boost::beast::http::read(server.next_layer(), buffer, request);
  server.accept(request);
  return std::string(request[boost::beast::http::field::authorization]);
}

TEST_F(WebSocketViewerTest, TheTokenGoesWithTheOpening) {
  for (const auto& [token, header] : {std::pair<const char*, const char*>{"kerf_a_b", "Bearer kerf_a_b"}, {"", ""}}) {
    plan_.secrets.token = token;
    const std::unique_ptr<Viewer> reader = viewer();
    boost::beast::websocket::stream<Tcp::socket> server(acceptor_.accept());
    EXPECT_EQ(accept_opening(server), header);
  }
}

class EncryptedViewerTest : public WebSocketViewerTest {
 protected:
  EncryptedViewerTest() {
    plan_.secrets = {.token = "kerf_a_b", .use_tls = true, .authorities = authority_.content_of(authority_.ca())};
  }
  // Gives the server a certificate for `names`.
  void certify(const std::string& names) {
    const auto [certificate, key] = authority_.make("server", names);
    tls_.use_certificate_chain_file(certificate);
    tls_.use_private_key_file(key, boost::asio::ssl::context::pem);
  }

  const test::TestAuthority authority_;
  boost::asio::ssl::context tls_{boost::asio::ssl::context::tls_server};
};

TEST_F(EncryptedViewerTest, ReadsFramesAndShowsItsCertificate) {
  const auto [certificate, key] = authority_.make("client");
  plan_.secrets.certificate = authority_.content_of(certificate);
  plan_.secrets.key = authority_.content_of(key);
  certify("IP:127.0.0.1");
  tls_.load_verify_file(authority_.ca());
  tls_.set_verify_mode(boost::asio::ssl::verify_peer | boost::asio::ssl::verify_fail_if_no_peer_cert);
  const std::unique_ptr<Viewer> reader = viewer();
  boost::beast::websocket::stream<boost::asio::ssl::stream<Tcp::socket>> server(acceptor_.accept(), tls_);
  server.next_layer().handshake(boost::asio::ssl::stream_base::server);
  EXPECT_EQ(accept_opening(server), "Bearer kerf_a_b");
  server.binary(true);
  boost::beast::flat_buffer start;
  server.read(start);
  server.write(boost::asio::buffer(frame_message()));
  boost::beast::flat_buffer acknowledgement;
  server.read(acknowledgement);
  EXPECT_EQ(recorder_.readers(Role::kViewer).readers, 1);
}

TEST_F(EncryptedViewerTest, DoesNotTrustAServerWithAnotherName) {
  certify("DNS:kerf.example.org");
  const std::unique_ptr<Viewer> reader = viewer();
  boost::beast::websocket::stream<boost::asio::ssl::stream<Tcp::socket>> server(acceptor_.accept(), tls_);
  boost::system::error_code refused;
  server.next_layer().handshake(boost::asio::ssl::stream_base::server, refused);
  while (recorder_.readers(Role::kViewer).ends.empty()) std::this_thread::sleep_for(1ms);
  EXPECT_NE(recorder_.readers(Role::kViewer).ends.begin()->first.find("verify failed"), std::string::npos);
}

TEST_F(EncryptedViewerTest, WithKeysThatCannotBeReadItEnds) {
  plan_.secrets.authorities = "-----BEGIN CERTIFICATE-----\nno\n-----END CERTIFICATE-----\n";
  const std::unique_ptr<Viewer> reader = viewer();
  const Tcp::socket silent = acceptor_.accept();
  while (recorder_.readers(Role::kViewer).ends.empty()) std::this_thread::sleep_for(1ms);
}

}  // namespace
}  // namespace kerf::load
