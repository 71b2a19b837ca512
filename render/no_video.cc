#include "render/video.h"

// Replaces video.cc in builds without libvpx or libyuv.
namespace kerf::render {

bool video_available() {
  return false;
}

Status make_video_encoder(const VideoOptions& /*options*/, std::unique_ptr<VideoEncoder>& encoder) {
  encoder.reset();
  return {StatusCode::kUnavailable, "NO_VIDEO_CODEC",
          "built without video (KERF_RENDER=OFF, or libvpx-dev and libyuv-dev were missing); use JPEG", ""};
}

}  // namespace kerf::render
