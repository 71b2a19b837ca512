#pragma once

#include <string>

#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>

#include "client/cpp/credentials.h"

// TLS of the connections to the viewer's port; gRPC has its own.
namespace kerf::load {

using TlsStream = boost::beast::ssl_stream<boost::beast::tcp_stream>;

// Sets the authorities to trust and the certificate to show. Returns an error if OpenSSL cannot read them.
boost::system::error_code prepare(const client::Secrets& secrets, boost::asio::ssl::context& context);

// Names the server that the stream is to reach; its certificate must have that name. `host`: that of the address.
void expect_server(const client::Secrets& secrets, const std::string& host, TlsStream& stream);

}  // namespace kerf::load
