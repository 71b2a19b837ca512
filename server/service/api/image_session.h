#pragma once

#include <memory>
#include <optional>

#include "server/service/api/stream_session.h"

namespace kerf::v1 {
class WatchImagesStart;
}  // namespace kerf::v1

namespace kerf::api {

struct ApiCore;

// One stream of RenderService.WatchImages. Made by Api::watch_images(). What breaks its protocol: no or second start,
// an unknown sheet, acknowledging what was not sent, a view or pace out of range, a message without a kind.
class ImageSession : public StreamSession {
 public:
  // next(), but only the picture: for a transport that has a framing of its own.
  virtual std::optional<stream::Bytes> next_picture() = 0;
};

std::shared_ptr<ImageSession> make_image_session(const std::shared_ptr<ApiCore>& core);

// One that has been started, takes no requests and owes no acknowledgements.
std::shared_ptr<ImageSession> make_image_player(const std::shared_ptr<ApiCore>& core,
                                                const v1::WatchImagesStart& start);

}  // namespace kerf::api
