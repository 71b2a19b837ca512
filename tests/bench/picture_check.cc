#include "tests/bench/picture_check.h"

#include <png.h>
#include <turbojpeg.h>
#include <vpx/vp8dx.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "server/base/check.h"

namespace kerf::bench {
namespace {

// Returns the brightness of a pixel, 0..255: BT.601, as in all three codecs.
double brightness(const std::uint8_t* rgba) {
  return 0.299 * rgba[0] + 0.587 * rgba[1] + 0.114 * rgba[2];
}

std::string size_fault(unsigned width, unsigned height, const render::Pixels& drawn) {
  if (width == static_cast<unsigned>(drawn.width) && height == static_cast<unsigned>(drawn.height)) return {};
  return "it has " + std::to_string(width) + " x " + std::to_string(height) + " pixels";
}

// `grey(x, y)`: of the decoded picture, 0..255.
template <typename Grey>
std::string distance_fault(const render::Pixels& drawn, double min_psnr, const Grey& grey) {
  double sum = 0.0;
  for (int y = 0; y < drawn.height; ++y) {
    for (int x = 0; x < drawn.width; ++x) {
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(drawn.width) + static_cast<std::size_t>(x);
      const double error = grey(x, y) - brightness(&drawn.rgba[4 * pixel]);
      sum += error * error;
    }
  }
  const double mean = sum / (static_cast<double>(drawn.width) * drawn.height);
  const double psnr = 10.0 * std::log10(255.0 * 255.0 / std::max(mean, 1e-9));
  return psnr >= min_psnr ? std::string() : "it is " + std::to_string(psnr) + " dB from what was drawn";
}

}  // namespace

std::string jpeg_fault(std::span<const std::uint8_t> jpeg, const render::Pixels& drawn, double min_psnr) {
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colours = 0;
  if (tjDecompressHeader3(decoder.get(), jpeg.data(), jpeg.size(), &width, &height, &subsampling, &colours) != 0) {
    return "it is no JPEG";
  }
  std::string fault = size_fault(static_cast<unsigned>(width), static_cast<unsigned>(height), drawn);
  if (!fault.empty()) return fault;
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (tjDecompress2(decoder.get(), jpeg.data(), jpeg.size(), grey.data(), width, 0, height, TJPF_GRAY, 0) != 0) {
    return "it cannot be decoded";
  }
  return distance_fault(drawn, min_psnr, [&](int x, int y) {
    return static_cast<double>(grey[static_cast<std::size_t>(y * width + x)]);
  });
}

std::string png_fault(std::span<const std::uint8_t> png, const render::Pixels& drawn) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) return "it is no PNG";
  image.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> rgba(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, rgba.data(), 0, nullptr) == 0) return "it cannot be decoded";
  std::string fault = size_fault(image.width, image.height, drawn);
  if (fault.empty() && rgba != drawn.rgba) fault = "it is not what was drawn";
  return fault;
}

VideoCheck::VideoCheck() {
  KERF_CHECK(vpx_codec_dec_init(&codec_, vpx_codec_vp8_dx(), nullptr, 0) == VPX_CODEC_OK, "no VP8 decoder");
}

VideoCheck::~VideoCheck() {
  vpx_codec_destroy(&codec_);
}

std::string VideoCheck::fault(std::span<const std::uint8_t> frame, const render::Pixels& drawn, double min_psnr) {
  if (vpx_codec_decode(&codec_, frame.data(), static_cast<unsigned>(frame.size()), nullptr, 0) != VPX_CODEC_OK) {
    return "it cannot be decoded";
  }
  vpx_codec_iter_t iterator = nullptr;
  const vpx_image_t* image = vpx_codec_get_frame(&codec_, &iterator);
  if (image == nullptr) return "it shows nothing";
  std::string fault = size_fault(image->d_w, image->d_h, drawn);
  if (!fault.empty()) return fault;
  return distance_fault(drawn, min_psnr, [&](int x, int y) {
    return (image->planes[VPX_PLANE_Y][y * image->stride[VPX_PLANE_Y] + x] - 16) * 255.0 / 219.0;
  });
}

double covered_share(const render::Pixels& pixels) {
  std::size_t covered = 0;
  for (std::size_t i = 0; i < pixels.rgba.size(); i += 4) {
    covered +=
        std::equal(pixels.rgba.begin(), pixels.rgba.begin() + 4, pixels.rgba.begin() + static_cast<std::ptrdiff_t>(i))
            ? 0U
            : 1U;
  }
  return 4.0 * static_cast<double>(covered) / static_cast<double>(pixels.rgba.size());
}

}  // namespace kerf::bench
