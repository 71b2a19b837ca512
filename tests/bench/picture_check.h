#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <vpx/vpx_decoder.h>

#include "render/image.h"

// Checks that encoded pictures show the drawing: each is decoded by the library that its readers use.
namespace kerf::bench {

// Empty where it is right, else what is wrong: of another size, or less than `min_psnr` dB near to the brightness of
// the pixels. PNG must be equal byte for byte.
std::string jpeg_fault(std::span<const std::uint8_t> jpeg, const render::Pixels& drawn, double min_psnr);
std::string png_fault(std::span<const std::uint8_t> png, const render::Pixels& drawn);

// Checks one VP8 stream, whose frames must all be given in order.
class VideoCheck {
 public:
  VideoCheck();
  ~VideoCheck();
  VideoCheck(const VideoCheck&) = delete;
  VideoCheck& operator=(const VideoCheck&) = delete;

  std::string fault(std::span<const std::uint8_t> frame, const render::Pixels& drawn, double min_psnr);

 private:
  vpx_codec_ctx_t codec_{};
};

// The share of pixels that differ from the upper left one, which shows the background: 0 of a blank picture.
double covered_share(const render::Pixels& pixels);

}  // namespace kerf::bench
