#pragma once

#include <utility>

#include <boost/asio/ssl/context.hpp>

#include <memory>
#include <string>

#include "server/base/result.h"

namespace kerf::ws {

// Holds the certificate, the key and the rules of TLS for the connections of a server. The rules: TLS 1.2 or later; for
// 1.2 only ciphers with ephemeral keys and authentication (ECDHE with AEAD); no compression, no renegotiation, no
// resumption of sessions.
class TlsContext {
 public:
  // `certificate_chain`: PEM text, the server's own certificate first. `key`: PEM text of its private key, without a
  // password. Error: kInvalidArgument BAD_CERTIFICATE with the words of OpenSSL.
  static Result<std::shared_ptr<TlsContext>> make(const std::string& certificate_chain, const std::string& key);

  [[nodiscard]] boost::asio::ssl::context& native() { return context_; }

 private:
  TlsContext();

  boost::asio::ssl::context context_;
};

// True for the error of a handshake whose client speaks HTTP without TLS.
bool is_plain_http(const boost::system::error_code& handshake_error);

}  // namespace kerf::ws
