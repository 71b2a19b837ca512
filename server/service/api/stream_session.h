#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "server/base/result.h"
#include "server/service/stream/message.h"

namespace kerf::api {

// One stream that server and client both talk on, whatever carries it.
//
// The transport reads requests and hands each to on_bytes(), in order. It writes what next() gives, one message at a
// time: after a write is done it calls next() again; when next() gives nothing it waits for the ready callback. Once
// ended() is true and next() gives nothing more, it closes the stream: with the status of failure() if there is one,
// else cleanly. It calls close() when its side is gone, in any case, once or more.
//
// Safe to call from any thread, also from within the ready callback.
class StreamSession {
 public:
  virtual ~StreamSession() = default;

  // A serialised request. The first must be `start`, and only the first. What breaks the protocol ends the stream with
  // failure(): MALFORMED_MESSAGE where it is no request at all.
  virtual void on_bytes(std::string_view request) = 0;

  // The next serialised response, or nothing now.
  virtual std::optional<stream::Message> next() = 0;

  // `ready` is called whenever next() may have something, or the stream has ended; possibly in vain, never under a
  // lock, from any thread, at once if there is something already. An empty function removes it: it is not called any
  // more after set_ready({}) has returned, unless the call comes from within it.
  virtual void set_ready(std::function<void()> ready) = 0;

  // Nothing will be added to what next() still has to give.
  [[nodiscard]] virtual bool ended() const = 0;
  // Why the stream is refused; nothing while it is open and after a regular end.
  [[nodiscard]] virtual std::optional<Error> failure() const = 0;

  // The client is gone or has finished: leaves the sheet and lets go of what the stream held.
  virtual void close() = 0;
};

}  // namespace kerf::api
