#pragma once

#include <utility>

#include <boost/asio/awaitable.hpp>
#include <boost/beast/core/tcp_stream.hpp>

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>

#include "server/service/api/image_session.h"

namespace kerf::ws {

struct MjpegTimes {
  std::chrono::milliseconds write_timeout;  // for one picture to be taken
  std::chrono::milliseconds repeat_after;   // the last picture is sent again where there is no other for so long
};

// Writes the pictures of `session` as multipart/x-mixed-replace until it ends, the reader hangs up (`hung_up`) or takes
// longer than `write_timeout` for one of them; then the connection is to be closed. A reader that has vanished without
// a word is found out by what is sent again, which it does not acknowledge. On the socket's strand. No picture
// is drawn before the one before it has left this machine, but for some 16 KiB, so that what a slow reader gets is only
// as old as what the way and its own buffers hold. Returns why there is no first picture, with nothing written; nothing
// where there was one.
boost::asio::awaitable<std::optional<Error>> play_mjpeg(std::shared_ptr<api::ImageSession> session,
                                                        boost::beast::tcp_stream& stream, MjpegTimes times,
                                                        std::stop_token hung_up);

}  // namespace kerf::ws
