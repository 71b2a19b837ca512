#pragma once

#include <utility>

#include <boost/asio/awaitable.hpp>

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>

#include "server/service/api/image_session.h"
#include "server/service/ws/cross_origin.h"
#include "server/service/ws/transport.h"

namespace kerf::ws {

struct MjpegTimes {
  std::chrono::milliseconds write_timeout;  // Longest time for the reader to take one picture.
  std::chrono::milliseconds repeat_after;   // The last picture is sent again after this long without a new one.
};

// Writes the pictures of `session` as multipart/x-mixed-replace, on the socket's strand. Ends with the session, when
// the reader hangs up (`hung_up`), or when it takes longer than `write_timeout` for a picture. The connection must then
// be closed. Repeated pictures detect a reader that vanished silently, because it does not acknowledge them.
//
// A picture is drawn only once all but some 16 KiB of the one before has left this machine. Thus pictures for a slow
// reader are only as old as the link and its own buffers make them. Returns the error if there is no first picture,
// with nothing written; nothing otherwise.
//
// `Stream` is PlainStream or TlsStream. `headers`: further ones of the answer.
template <typename Stream>
boost::asio::awaitable<std::optional<Error>> play_mjpeg(std::shared_ptr<api::ImageSession> session, Stream& stream,
                                                        MjpegTimes times, HeaderLines headers, std::stop_token hung_up);

}  // namespace kerf::ws
