#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "render/video.h"
#include "server/base/result.h"
#include "server/service/host/clock.h"

namespace kerf::api {

// The VP8 frames of one stream as long as its size and bit rate stay the same. Each stream has an encoder of its own,
// whoever else looks at the same view: a frame can be decoded only after those that the same encoder made before, and
// every reader skips at its own pace. Shared is what is drawn. Not thread-safe.
class VideoTrack {
 public:
  // Limits as of render::VideoOptions.
  explicit VideoTrack(const render::VideoOptions& options) : options_(options) {}

  struct Frame {
    std::string bytes;
    bool key = false;
  };
  // `now`: when the picture is encoded, later than that before. Errors of the encoder, after which there are no more.
  Result<Frame> encode(const render::Pixels& pixels, host::Nanoseconds now, bool key);

  [[nodiscard]] const render::VideoOptions& options() const { return options_; }

 private:
  const render::VideoOptions options_;
  std::unique_ptr<render::VideoEncoder> encoder_;  // made with the first frame
  host::Nanoseconds last_at_{0};                   // that frame was encoded
};

}  // namespace kerf::api
