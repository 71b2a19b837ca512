#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/certificates.h"
#include "tests/ws/raw_client.h"

struct ssl_st;

namespace kerf::ws_test {

// Says how a client of TLS introduces itself. Empty texts leave the choice to OpenSSL.
struct TlsOffer {
  std::string authority{};          // PEM; the server's certificate must come from it.
  int version = 0;                  // The only one, such as TLS1_2_VERSION; 0: any.
  std::string ciphers{};            // For TLS 1.2 and before.
  std::vector<std::string> alpn{};  // Protocols.
  test::Identity identity{};        // Its own certificate.
};

// A RawClient over TLS.
class TlsClient : public RawClient {
 public:
  // Connects and shakes hands.
  TlsClient(int port, const TlsOffer& offer);
  ~TlsClient() override;

  // Why the handshake failed, in the words of OpenSSL; empty if it did not.
  [[nodiscard]] const std::string& failure() const { return failure_; }
  [[nodiscard]] std::string version() const;   // "TLSv1.3"
  [[nodiscard]] std::string protocol() const;  // By ALPN.
  [[nodiscard]] bool is_resumable() const;     // The server keeps the session, or gave a ticket for it.
  // Says that this side sends no more, and leaves the connection open.
  void say_goodbye();
  // True if the server has said that it sends no more.
  [[nodiscard]] bool was_told_goodbye() const;
  // Asks for new keys of TLS 1.3: a record without content.
  void change_keys();
  // Asks for another handshake, of TLS 1.2; returns true if the server made it.
  bool renegotiate();
  // Sends bytes below TLS.
  void send_raw(std::string_view bytes) const;

 private:
  ssize_t write_some(std::string_view bytes) override;
  ssize_t read_some(char* bytes, std::size_t size) override;

  struct Free {
    void operator()(ssl_st* tls) const;
  };
  std::unique_ptr<ssl_st, Free> tls_;
  std::string failure_;
};

}  // namespace kerf::ws_test
