#include "client/load/tls.h"

#include <boost/asio/buffer.hpp>

namespace kerf::load {

namespace ssl = boost::asio::ssl;

boost::system::error_code prepare(const client::Secrets& secrets, ssl::context& context) {
  boost::system::error_code error;
  context.set_verify_mode(ssl::verify_peer, error);
  if (!error && secrets.authorities.empty()) context.set_default_verify_paths(error);
  if (!error && !secrets.authorities.empty()) {
    context.add_certificate_authority(boost::asio::buffer(secrets.authorities), error);
  }
  if (!error && !secrets.certificate.empty()) {
    context.use_certificate_chain(boost::asio::buffer(secrets.certificate), error);
    if (!error) context.use_private_key(boost::asio::buffer(secrets.key), ssl::context::pem, error);
  }
  return error;
}

void expect_server(const client::Secrets& secrets, const std::string& host, TlsStream& stream) {
  const std::string& name = secrets.tls_name.empty() ? host : secrets.tls_name;
  SSL_set_tlsext_host_name(stream.native_handle(), name.c_str());
  boost::system::error_code ignored;  // The call fails only without memory.
  stream.set_verify_callback(ssl::host_name_verification(name), ignored);
}

}  // namespace kerf::load
