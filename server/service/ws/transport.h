#pragma once

#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>

#include <type_traits>

#include "server/service/ws/watched_reads.h"

namespace kerf::ws {

// Carries the bytes of HTTP: TCP as it is, or TLS over TCP. beast::get_lowest_layer() is a PlainStream in both cases,
// and has the timeouts and the socket.
using PlainStream =
    boost::beast::basic_stream<boost::asio::ip::tcp, boost::beast::tcp_stream::executor_type, StoppableReads>;
using TlsStream = boost::beast::ssl_stream<PlainStream>;

template <typename Stream>
inline constexpr bool kIsTls = std::is_same_v<Stream, TlsStream>;

}  // namespace kerf::ws
