#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>

#include "tests/support/certificates.h"
#include "tests/support/temporary_folder.h"
#include "tests/ws/http_fixture.h"
#include "tests/ws/tls_client.h"

// A whole kerfd with TLS, and its certificates.
namespace kerf::ws_test {

class TlsTest : public ::testing::Test {
 protected:
  // Writes the files of `identity`, and names them to `config`.
  void use(app::Config& config, const test::Identity& identity) const {
    config.tls.certificate = folder_.write("server.pem", identity.certificate).string();
    config.tls.key = folder_.write("server.key", identity.key).string();
  }
  void start(app::Config config = test_config()) {
    config.web = write_viewer(folder_);
    use(config, authority_.issue("localhost"));
    server_ = start_server(config);
    ASSERT_NE(server_, nullptr);
    port_ = port_of(server_->http_url());
  }
  void TearDown() override { server_.reset(); }

  [[nodiscard]] TlsOffer offer() const { return {.authority = authority_.certificate()}; }
  [[nodiscard]] std::unique_ptr<TlsClient> connect() const {
    auto client = std::make_unique<TlsClient>(port_, offer());
    EXPECT_EQ(client->failure(), "");
    return client;
  }
  [[nodiscard]] Response ask(std::string_view method, std::string_view target, std::string_view headers = {},
                             std::string_view body = {}) const {
    return request(*connect(), port_, method, target, headers, body);
  }
  [[nodiscard]] Response call(const std::string& method, std::string_view json, std::string_view headers = {}) const {
    return ask("POST", "/kerf.v1." + method, headers, json);
  }
  [[nodiscard]] double metric(const std::string& name) const {
    const std::string page = ask("GET", "/metrics").body;
    const std::size_t found = page.find("\n" + name + " ");
    return found == std::string::npos ? -1.0 : std::stod(page.substr(found + name.size() + 2));
  }
  [[nodiscard]] RawWebSocket open_stream(std::string_view path, std::string_view headers = {}) const {
    return {connect(), port_, "Sec-WebSocket-Protocol: kerf.v1\r\n" + std::string(headers), path};
  }

  const test::TemporaryFolder folder_;
  const test::Authority authority_{"Kerf test authority"};
  std::unique_ptr<app::Server> server_;
  int port_ = 0;
};

}  // namespace kerf::ws_test
