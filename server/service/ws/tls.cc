#include "server/service/ws/tls.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/ssl/error.hpp>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/sslerr.h>

#include <array>
#include <string_view>

namespace kerf::ws {
namespace {

namespace asio = boost::asio;

constexpr int kSecurityLevel = 2;  // RSA keys of at least 2048 bits, no signatures with SHA-1.
constexpr const char* kCiphersOfTls12 = "ECDHE+AESGCM:ECDHE+CHACHA20:!aNULL";
// The one protocol of this port, in the form of ALPN (RFC 7301).
constexpr std::array<unsigned char, 9> kHttp11 = {8, 'h', 't', 't', 'p', '/', '1', '.', '1'};

// Ends the handshake of a client that names protocols, and HTTP/1.1 is none of them, such as one of gRPC.
int choose_protocol(SSL* /*connection*/, const unsigned char** chosen, unsigned char* chosen_size,
                    const unsigned char* offered, unsigned int offered_size, void* /*context*/) {
  // OpenSSL's parameter is not const, though it only points to what was given.
  auto* found = const_cast<unsigned char**>(chosen);
  const int outcome = SSL_select_next_proto(found, chosen_size, kHttp11.data(), kHttp11.size(), offered, offered_size);
  return outcome == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_ALERT_FATAL;
}

}  // namespace

TlsContext::TlsContext() : context_(asio::ssl::context::tls_server) {
  SSL_CTX* const context = context_.native_handle();
  SSL_CTX_set_security_level(context, kSecurityLevel);
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_cipher_list(context, kCiphersOfTls12);
  SSL_CTX_set_options(context, SSL_OP_NO_COMPRESSION | SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE |
                                   SSL_OP_PRIORITIZE_CHACHA | SSL_OP_NO_TICKET);
  // Keeps no session: a key for tickets would weaken the secrecy of all its connections, and connections are few and
  // long here.
  SSL_CTX_set_num_tickets(context, 0);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_alpn_select_cb(context, choose_protocol, nullptr);
  // Refuses a key with a password, for which OpenSSL would ask on the terminal.
  context_.set_password_callback([](std::size_t, asio::ssl::context::password_purpose) { return std::string(); });
}

Result<std::shared_ptr<TlsContext>> TlsContext::make(const std::string& certificate_chain, const std::string& key) {
  std::shared_ptr<TlsContext> made(new TlsContext);
  boost::system::error_code error;
  made->context_.use_certificate_chain(asio::buffer(certificate_chain), error);
  if (!error) made->context_.use_private_key(asio::buffer(key), asio::ssl::context::pem, error);
  if (error) {
    return invalid_argument("BAD_CERTIFICATE",
                            "OpenSSL does not take this certificate with this key: " + error.message());
  }
  return made;
}

bool is_plain_http(const boost::system::error_code& handshake_error) {
  return handshake_error.category() == asio::error::get_ssl_category() &&
         ERR_GET_REASON(static_cast<unsigned long>(handshake_error.value())) == SSL_R_HTTP_REQUEST;
}

}  // namespace kerf::ws
