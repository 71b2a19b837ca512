#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "server/base/result.h"
#include "server/service/stream/message.h"

namespace kerf::api {

// Defines one bidirectional stream, independent of its transport.
//
// The transport reads requests and passes each to on_bytes(), in order. It writes the messages of next(), one at a
// time: after each write it calls next() again, and if next() gives nothing it waits for the ready callback. Once
// ended() is true and next() gives nothing more, it closes the stream: with the status of failure() if there is one,
// else cleanly. It calls close() in any case when its side is gone, once or more.
//
// Callable from any thread, also from within the ready callback.
class StreamSession {
 public:
  virtual ~StreamSession() = default;

  // Takes a serialised request. The first request, and no other, must be `start`. A protocol error ends the stream with
  // failure(); MALFORMED_MESSAGE if the bytes are no request.
  virtual void on_bytes(std::string_view request) = 0;

  // Returns the next serialised response, or nothing now.
  virtual std::optional<stream::Message> next() = 0;

  // Sets the callback for when next() may have something, or the stream has ended. It may be called in vain, from any
  // thread, never under a lock, and at once if there is something already. An empty function removes it. After
  // set_wake({}) has returned it is not called any more, unless that call comes from within it.
  virtual void set_wake(std::function<void()> wake) = 0;

  // True once nothing will be added to the remaining messages of next().
  [[nodiscard]] virtual bool ended() const = 0;
  // Returns the reason for a refusal; nothing while the stream is open and after a regular end.
  [[nodiscard]] virtual std::optional<Error> failure() const = 0;

  // Ends the stream after the client is gone or has finished: leaves the sheet and frees the stream's resources.
  virtual void close() = 0;
};

}  // namespace kerf::api
