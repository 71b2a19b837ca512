#include "tests/ws/tls_client.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/socket.h>

#include <csignal>

namespace kerf::ws_test {
namespace {

struct FreeContext {
  void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
};
using Context = std::unique_ptr<SSL_CTX, FreeContext>;

BIO* reader_of(const std::string& text) {
  return BIO_new_mem_buf(text.data(), static_cast<int>(text.size()));
}

void trust(SSL_CTX* context, const std::string& authority) {
  BIO* const text = reader_of(authority);
  X509* const certificate = PEM_read_bio_X509(text, nullptr, nullptr, nullptr);
  X509_STORE_add_cert(SSL_CTX_get_cert_store(context), certificate);
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER, nullptr);
  X509_free(certificate);
  BIO_free(text);
}

void show(SSL_CTX* context, const test::Identity& identity) {
  BIO* const certificate_text = reader_of(identity.certificate);
  BIO* const key_text = reader_of(identity.key);
  X509* const certificate = PEM_read_bio_X509(certificate_text, nullptr, nullptr, nullptr);
  EVP_PKEY* const key = PEM_read_bio_PrivateKey(key_text, nullptr, nullptr, nullptr);
  SSL_CTX_use_certificate(context, certificate);
  SSL_CTX_use_PrivateKey(context, key);
  X509_free(certificate);
  EVP_PKEY_free(key);
  BIO_free(certificate_text);
  BIO_free(key_text);
}

Context make_context(const TlsOffer& offer) {
  Context context(SSL_CTX_new(TLS_client_method()));
  SSL_CTX_set_security_level(context.get(), 0);  // Also offers what a server should refuse.
  if (offer.version != 0) {
    SSL_CTX_set_min_proto_version(context.get(), offer.version);
    SSL_CTX_set_max_proto_version(context.get(), offer.version);
  }
  if (!offer.ciphers.empty()) SSL_CTX_set_cipher_list(context.get(), offer.ciphers.c_str());
  if (!offer.authority.empty()) trust(context.get(), offer.authority);
  if (!offer.identity.key.empty()) show(context.get(), offer.identity);
  std::string protocols;
  for (const std::string& each : offer.alpn) protocols += static_cast<char>(each.size()) + each;
  SSL_CTX_set_alpn_protos(context.get(), reinterpret_cast<const unsigned char*>(protocols.data()),
                          static_cast<unsigned>(protocols.size()));
  return context;
}

}  // namespace

void TlsClient::Free::operator()(ssl_st* tls) const {
  SSL_free(tls);
}

TlsClient::TlsClient(int port, const TlsOffer& offer) : RawClient(port) {
  std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes without MSG_NOSIGNAL.
  const Context context = make_context(offer);
  tls_.reset(SSL_new(context.get()));
  SSL_set_fd(tls_.get(), socket());
  SSL_set_tlsext_host_name(tls_.get(), "localhost");
  if (!offer.authority.empty()) SSL_set1_host(tls_.get(), "localhost");
  ERR_clear_error();
  if (SSL_connect(tls_.get()) == 1) return;
  const char* const reason = ERR_reason_error_string(ERR_get_error());
  failure_ = reason == nullptr ? "the connection ended" : reason;
}

TlsClient::~TlsClient() = default;

std::string TlsClient::version() const {
  return SSL_get_version(tls_.get());
}

std::string TlsClient::protocol() const {
  const unsigned char* chosen = nullptr;
  unsigned size = 0;
  SSL_get0_alpn_selected(tls_.get(), &chosen, &size);
  return {reinterpret_cast<const char*>(chosen), size};
}

bool TlsClient::is_resumable() const {
  return SSL_SESSION_is_resumable(SSL_get_session(tls_.get())) == 1;
}

void TlsClient::say_goodbye() {
  SSL_shutdown(tls_.get());
}

bool TlsClient::was_told_goodbye() const {
  return (SSL_get_shutdown(tls_.get()) & SSL_RECEIVED_SHUTDOWN) != 0;
}

void TlsClient::change_keys() {
  SSL_key_update(tls_.get(), SSL_KEY_UPDATE_REQUESTED);
  SSL_do_handshake(tls_.get());
}

bool TlsClient::renegotiate() {
  return SSL_renegotiate(tls_.get()) == 1 && SSL_do_handshake(tls_.get()) == 1;
}

void TlsClient::send_raw(std::string_view bytes) const {
  ::send(socket(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

ssize_t TlsClient::write_some(std::string_view bytes) {
  return SSL_write(tls_.get(), bytes.data(), static_cast<int>(bytes.size()));
}

ssize_t TlsClient::read_some(char* bytes, std::size_t size) {
  const int read = SSL_read(tls_.get(), bytes, static_cast<int>(size));
  if (read > 0) return read;
  return SSL_get_error(tls_.get(), read) == SSL_ERROR_WANT_READ ? -1 : 0;  // -1: nothing came in time.
}

}  // namespace kerf::ws_test
