#pragma once

#include "server/service/api/stream_session.h"

namespace kerf::v1 {
class WatchRequest;
}  // namespace kerf::v1

namespace kerf::api {

// Serves one stream of StreamService.Watch. Made by Api::watch(). Protocol errors: no or second start, an unknown
// sheet, acknowledging what was not sent, a message without a kind. A refused grab, drag or release is reported in the
// stream as a Rejection. close() releases the grabs made here.
class WatchSession : public StreamSession {
 public:
  // Does the same as on_bytes() with the serialised request.
  virtual void on_request(const v1::WatchRequest& request) = 0;
};

}  // namespace kerf::api
