#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "render/video.h"
#include "server/base/result.h"
#include "server/service/host/clock.h"

namespace kerf::picture {

// Encodes the VP8 frames of one stream while its size and bit rate stay the same. Streams of the same view share the
// drawing but not the encoder: a frame can be decoded only after the earlier frames of its encoder, and every reader
// skips at its own pace. Not thread-safe.
class VideoTrack {
 public:
  // `options`: limits as in render::VideoOptions.
  explicit VideoTrack(const render::VideoOptions& options) : options_(options) {}

  struct Frame {
    std::string bytes;
    bool key = false;
  };
  // Encodes one picture. `now`: the present time, later than that of the call before. `key`: requests a frame that can
  // be decoded by itself. Errors of the encoder; the track must not be used after one.
  Result<Frame> encode(const render::Pixels& pixels, host::Nanoseconds now, bool key);

  [[nodiscard]] const render::VideoOptions& options() const { return options_; }

 private:
  const render::VideoOptions options_;
  std::unique_ptr<render::VideoEncoder> encoder_;  // Made with the first frame.
  host::Nanoseconds last_at_{0};                   // Time of the last frame.
};

}  // namespace kerf::picture
