#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/image.h"

namespace kerf::render {

inline constexpr int kMaxVideoPixels = 1920 * 1200;  // Per frame.

struct VideoOptions {
  int width = 0;               // Pixels, in [kMinImageSize, kMaxImageSize]; width * height at most kMaxVideoPixels.
  int height = 0;              // pixels
  double bits_per_second = 0;  // Target rate of the stream, > 0.

  friend bool operator==(const VideoOptions&, const VideoOptions&) = default;
};

// Encodes one VP8 stream (RFC 6386) for live viewing: no frame waits for a later one, none is dropped. Equal calls give
// equal bytes. Not thread-safe.
class VideoEncoder {
 public:
  virtual ~VideoEncoder() = default;

  // Encodes a frame. `elapsed_s`: time since the frame before, > 0; the longer, the more bits the frame may take.
  // `key`: makes the frame decodable by itself, as the first frame always is. `frame` is overwritten; on failure it is
  // empty and the encoder must be destroyed. Errors: "IMAGE_INVALID" if the pixels do not have the size of the stream,
  // "ENCODING_FAILED".
  virtual Status encode(const Pixels& pixels, double elapsed_s, bool key, std::vector<std::uint8_t>& frame) = 0;
};

// False in a build without libvpx and libyuv.
[[nodiscard]] bool video_available();

// True if an encoded frame can be decoded by itself (RFC 6386, 9.1).
[[nodiscard]] inline bool is_key_frame(std::span<const std::uint8_t> frame) {
  return !frame.empty() && (frame[0] & 1U) == 0;
}

// Makes an encoder. Errors: "NO_VIDEO_CODEC" (kUnavailable), "SIZE_OUT_OF_RANGE", "ENCODING_FAILED"; `encoder` is then
// null.
Status make_video_encoder(const VideoOptions& options, std::unique_ptr<VideoEncoder>& encoder);

}  // namespace kerf::render
