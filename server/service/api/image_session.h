#pragma once

#include <memory>
#include <optional>

#include "server/service/api/stream_session.h"
#include "server/service/auth/grant.h"

namespace kerf::v1 {
class WatchImagesStart;
}  // namespace kerf::v1

namespace kerf::api {

struct ApiCore;

// Serves one stream of RenderService.WatchImages. Made by Api::watch_images(). Protocol errors: no or second start, an
// unknown sheet, acknowledging what was not sent, a view or frame rate out of range, a message without a kind.
class ImageSession : public StreamSession {
 public:
  // Returns only the picture of next(), for a transport with its own framing.
  virtual std::optional<stream::Bytes> next_picture() = 0;
};

// `caller`: who watches. If it is an error, the stream has failed with it.
std::shared_ptr<ImageSession> make_image_session(const std::shared_ptr<ApiCore>& core,
                                                 const Result<auth::Caller>& caller);

// Returns a started session that takes no requests and owes no acknowledgements.
std::shared_ptr<ImageSession> make_image_player(const std::shared_ptr<ApiCore>& core,
                                                const Result<auth::Caller>& caller, const v1::WatchImagesStart& start);

}  // namespace kerf::api
