// Connections to a server that a token or TLS may protect, and pages of its viewer's port.

#include "client/load/server_probe.h"

#include <optional>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>

#include "client/load/viewer.h"
#include "tests/client/asking_server.h"
#include "tests/support/test_authority.h"

namespace kerf::load {
namespace {

namespace http = boost::beast::http;
using boost::asio::ip::tcp;

// Answers one request on its own thread with the header `Authorization` that it had.
class PageServer {
 public:
  explicit PageServer(boost::asio::ssl::context* tls = nullptr) : thread_([this, tls] { serve(tls); }) {}
  ~PageServer() { thread_.join(); }
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  void serve(boost::asio::ssl::context* tls) {
    tcp::socket socket = acceptor_.accept();
    if (tls == nullptr) return answer(socket);
    boost::asio::ssl::stream<tcp::socket&> encrypted(socket, *tls);
    boost::system::error_code refused;
    encrypted.handshake(boost::asio::ssl::stream_base::server, refused);
    if (!refused) answer(encrypted);
  }

  template <typename Stream>
  static void answer(Stream& stream) {
    boost::beast::flat_buffer buffer;
    http::request<http::string_body> request;
    boost::system::error_code refused;
    http::read(stream, buffer, request, refused);
    if (refused) return;
    http::response<http::string_body> page(http::status::ok, 11);
    page.body() = std::string(request.target()) + " " + std::string(request[http::field::authorization]);
    page.prepare_payload();
    http::write(stream, page);
  }

  boost::asio::io_context context_;
  tcp::acceptor acceptor_{context_, {boost::asio::ip::address_v4::loopback(), 0}};
  const int port_ = acceptor_.local_endpoint().port();
  std::thread thread_;
};

TEST(HttpGet, AsksWithTheToken) {
  const PageServer with;
  EXPECT_EQ(http_get(with.address(), "/metrics", {.token = "kerf_a_b"}), "/metrics Bearer kerf_a_b");
  const PageServer without;
  EXPECT_EQ(http_get(without.address(), "/metrics", {}), "/metrics ");
}

TEST(HttpGet, TrustsTheAuthoritiesOfThePlanAlone) {
  const test::TestAuthority authority;
  const test::TestAuthority other;
  const auto [certificate, key] = authority.make("server");
  boost::asio::ssl::context tls(boost::asio::ssl::context::tls_server);
  tls.use_certificate_chain_file(certificate);
  tls.use_private_key_file(key, boost::asio::ssl::context::pem);
  client::Secrets secrets{.token = "kerf_a_b", .use_tls = true, .authorities = authority.content_of(authority.ca())};
  {
    const PageServer server(&tls);
    EXPECT_EQ(http_get(server.address(), "/metrics", secrets), "/metrics Bearer kerf_a_b");
  }
  {
    const PageServer server(&tls);
    secrets.tls_name = "kerf.example.org";
    EXPECT_EQ(http_get(server.address(), "/metrics", secrets), std::nullopt);
  }
  {
    const PageServer server(&tls);
    secrets.tls_name.clear();
    secrets.authorities = other.content_of(other.ca());
    EXPECT_EQ(http_get(server.address(), "/metrics", secrets), std::nullopt);
  }
}

TEST(ConnectTo, AProxyShowsTheCertificateOfTheServerBehindIt) {
  const test::TestAuthority authority;
  const auto [certificate, key] = authority.make("server", "DNS:localhost");
  grpc::SslServerCredentialsOptions options;
  options.pem_key_cert_pairs.push_back({authority.content_of(key), authority.content_of(certificate)});
  const client_test::AskingServer server(grpc::SslServerCredentials(options));
  Plan plan;
  plan.server = "localhost" + server.address().substr(server.address().rfind(':'));
  plan.secrets = {.token = "kerf_a_b", .use_tls = true, .authorities = authority.content_of(authority.ca())};
  client::Client client = connect_to(server.address(), plan, client::Client::Connection::kOwn);
  v1::Access access;
  const grpc::Status status =
      client.call(&v1::AccessService::Stub::GetAccess, client.access(), v1::GetAccessRequest(), access);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_THAT(server.calls().at("/kerf.v1.AccessService/GetAccess"), testing::ElementsAre("Bearer kerf_a_b"));
}

}  // namespace
}  // namespace kerf::load
