#include "render/image.h"

// Replaces image.cc in builds without libpng or libturbojpeg.
namespace kerf::render {

namespace {

Status no_codecs() {
  return {StatusCode::kUnavailable, "NO_IMAGE_CODECS",
          "built without image codecs (KERF_RENDER=OFF, or libpng-dev and libturbojpeg0-dev were missing)", ""};
}

}  // namespace

bool image_codecs_available() {
  return false;
}

Status encode_png(const Pixels& /*pixels*/, std::vector<std::uint8_t>& png) {
  png.clear();
  return no_codecs();
}

Status encode_jpeg(const Pixels& /*pixels*/, int /*quality*/, std::vector<std::uint8_t>& jpeg) {
  jpeg.clear();
  return no_codecs();
}

}  // namespace kerf::render
