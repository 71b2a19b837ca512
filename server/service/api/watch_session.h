#pragma once

#include "server/service/api/stream_session.h"

namespace kerf::v1 {
class WatchRequest;
}  // namespace kerf::v1

namespace kerf::api {

// One stream of StreamService.Watch. Made by Api::watch(). What breaks its protocol: no or second start, an unknown
// sheet, acknowledging what was not sent, a message without a kind. A refused grab, drag or release is told in the
// stream as a Rejection. close() releases the grabs made here.
class WatchSession : public StreamSession {
 public:
  // on_bytes() of the serialised request.
  virtual void on_request(const v1::WatchRequest& request) = 0;
};

}  // namespace kerf::api
