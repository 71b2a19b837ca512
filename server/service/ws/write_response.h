#pragma once

#include <utility>

#include <boost/asio/awaitable.hpp>

#include "server/service/ws/connection.h"
#include "server/service/ws/router.h"

namespace kerf::ws {

// Holds the properties of a request that determine the framing of its response.
struct Framing {
  unsigned version = 11;
  bool keep_alive = false;
  bool head = false;  // HEAD: length without body.
};

// Counts and writes a response within the limits of the options; returns false if the connection failed. `Stream` is
// PlainStream or TlsStream.
template <typename Stream>
boost::asio::awaitable<bool> write_response(Stream& stream, ConnectionContext& context, const HttpResponse& response,
                                            Framing framing);

}  // namespace kerf::ws
