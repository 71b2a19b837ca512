#include "server/service/api/image_request.h"

#include <algorithm>
#include <cmath>

#include "server/service/api/flow_request.h"

namespace kerf::api {
namespace {

constexpr int kStreamJpegQuality = 80;
constexpr int kMinBitrateKbps = 50;
constexpr int kMaxBitrateKbps = 50'000;

// Returns the bit rate in kbit/s, 2000 at 640 x 360. It grows less than the number of pixels, because more pixels show
// the same things larger.
int bitrate_for(const picture::PictureView& view) {
  const double pixels = static_cast<double>(view.width) * view.height;
  const double kbps = 2000.0 * std::pow(pixels / (640.0 * 360.0), 0.75);
  return std::clamp(static_cast<int>(std::lround(kbps)), kMinBitrateKbps, kMaxBitrateKbps);
}

Result<v1::ImageCodec> decode_codec(v1::ImageCodec codec) {
  switch (codec) {
    case v1::IMAGE_CODEC_UNSPECIFIED:
      return v1::IMAGE_JPEG;
    case v1::IMAGE_JPEG:
    case v1::IMAGE_PNG:
      return codec;
    case v1::IMAGE_VP8:
      if (render::video_available()) return codec;
      return unavailable("NO_VIDEO_CODEC", "this server was built without VP8; request IMAGE_JPEG (1)", "start.codec");
    default:
      return invalid_argument("UNKNOWN_ENUM_VALUE",
                              "start.codec is " + std::to_string(codec) +
                                  "; must be IMAGE_JPEG (1), IMAGE_PNG (2) or IMAGE_VP8 (3), or 0 for IMAGE_JPEG",
                              "start.codec");
  }
}

Status check_video_size(const picture::PictureView& view, const std::string& prefix) {
  if (std::int64_t{view.width} * view.height <= render::kMaxVideoPixels) return Nothing{};
  return invalid_argument("OUT_OF_RANGE",
                          "a picture of " + std::to_string(view.width) + " x " + std::to_string(view.height) +
                              " has more than the " + std::to_string(render::kMaxVideoPixels) +
                              " pixels (1920 x 1200) that VP8 pictures may have; make it smaller, or request JPEG",
                          prefix + "width_px");
}

}  // namespace

Result<ImageLook> decode_look(const v1::ImageView& message, v1::ImageCodec codec, const std::string& prefix) {
  KERF_TRY_ASSIGN(const picture::PictureView view, picture::decode_view(message, prefix));
  const int quality = message.jpeg_quality() != 0 ? message.jpeg_quality() : kStreamJpegQuality;
  Status status = picture::check_range(quality, 1, 100, prefix + "jpeg_quality");
  const int kbps = message.bitrate_kbps() != 0 ? message.bitrate_kbps() : bitrate_for(view);
  if (status.ok()) status = picture::check_range(kbps, kMinBitrateKbps, kMaxBitrateKbps, prefix + "bitrate_kbps");
  if (status.ok() && codec == v1::IMAGE_VP8) status = check_video_size(view, prefix);
  KERF_TRY(status);
  ImageLook look{view, {}, {}};
  if (codec == v1::IMAGE_VP8) look.video = {view.width, view.height, 1000.0 * kbps};
  if (codec == v1::IMAGE_JPEG) look.still = {true, quality};
  return look;
}

Result<ImageRequest> decode_image_request(const v1::WatchImagesStart& start, const Limits& limits) {
  KERF_TRY_ASSIGN(const stream::FlowOptions flow, decode_flow(start.window(), start.max_rate_hz(), limits));
  KERF_TRY_ASSIGN(const v1::ImageCodec codec, decode_codec(start.codec()));
  KERF_TRY_ASSIGN(const ImageLook look, decode_look(start.view(), codec, "start.view."));
  return ImageRequest{flow, codec, look};
}

}  // namespace kerf::api
