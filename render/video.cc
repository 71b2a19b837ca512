#include "render/video.h"

#include <libyuv/convert.h>
#include <vpx/vp8cx.h>
#include <vpx/vpx_encoder.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace kerf::render {

namespace {

constexpr int kTicksPerSecond = 1'000'000;
// A negative speed is fixed. A positive one would follow the machine's load, so that equal pictures gave different
// bytes. Speed 8 takes 5.3 ms a frame at 720p, the default several times as long.
constexpr int kSpeed = -8;

Status encoding_failed(const std::string& words) {
  return {StatusCode::kInternal, "ENCODING_FAILED", "libvpx: " + words, ""};
}

class Vp8Encoder final : public VideoEncoder {
 public:
  Vp8Encoder() = default;
  ~Vp8Encoder() override {
    if (open_) vpx_codec_destroy(&codec_);
    vpx_img_free(image_);
  }
  Vp8Encoder(const Vp8Encoder&) = delete;
  Vp8Encoder& operator=(const Vp8Encoder&) = delete;

  Status open(const VideoOptions& options);
  Status encode(const Pixels& pixels, double elapsed_s, bool key, std::vector<std::uint8_t>& frame) override;

 private:
  vpx_codec_ctx_t codec_{};
  bool open_ = false;
  vpx_image_t* image_ = nullptr;
  vpx_codec_pts_t now_ = 0;
};

Status Vp8Encoder::open(const VideoOptions& options) {
  vpx_codec_enc_cfg_t config;
  if (vpx_codec_enc_config_default(vpx_codec_vp8_cx(), &config, 0) != VPX_CODEC_OK) {
    return encoding_failed("no default configuration");
  }
  config.g_w = static_cast<unsigned>(options.width);
  config.g_h = static_cast<unsigned>(options.height);
  config.g_timebase = {1, kTicksPerSecond};
  config.g_threads = 1;
  config.g_lag_in_frames = 0;
  config.g_error_resilient = 0;  // The transport loses no frames.
  config.rc_end_usage = VPX_CBR;
  config.rc_target_bitrate = static_cast<unsigned>(std::lround(options.bits_per_second / 1000.0));
  config.rc_dropframe_thresh = 0;
  config.rc_resize_allowed = 0;
  config.rc_min_quantizer = 4;
  config.rc_max_quantizer = 56;
  config.kf_mode = VPX_KF_DISABLED;
  image_ = vpx_img_alloc(nullptr, VPX_IMG_FMT_I420, config.g_w, config.g_h, 32);
  if (image_ == nullptr) return encoding_failed("no memory for a picture");
  if (vpx_codec_enc_init(&codec_, vpx_codec_vp8_cx(), &config, 0) != VPX_CODEC_OK) {
    return encoding_failed(vpx_codec_error(&codec_));
  }
  open_ = true;
  if (vpx_codec_control(&codec_, VP8E_SET_CPUUSED, kSpeed) != VPX_CODEC_OK ||
      vpx_codec_control(&codec_, VP8E_SET_STATIC_THRESHOLD, 1U) != VPX_CODEC_OK) {
    return encoding_failed(vpx_codec_error(&codec_));
  }
  return {};
}

Status Vp8Encoder::encode(const Pixels& pixels, double elapsed_s, bool key, std::vector<std::uint8_t>& frame) {
  frame.clear();
  if (pixels.width != static_cast<int>(image_->d_w) || pixels.height != static_cast<int>(image_->d_h) ||
      pixels.rgba.size() != 4 * static_cast<std::size_t>(pixels.width) * static_cast<std::size_t>(pixels.height)) {
    return {StatusCode::kInvalidArgument, "IMAGE_INVALID", "the picture does not have the size of the stream",
            "pixels"};
  }
  // Uses ABGR, since libyuv names formats by the order in a little-endian word: R, G, B, A in memory.
  libyuv::ABGRToI420(pixels.rgba.data(), 4 * pixels.width, image_->planes[VPX_PLANE_Y], image_->stride[VPX_PLANE_Y],
                     image_->planes[VPX_PLANE_U], image_->stride[VPX_PLANE_U], image_->planes[VPX_PLANE_V],
                     image_->stride[VPX_PLANE_V], pixels.width, pixels.height);
  // Clamps the duration, so that a frame after a pause of minutes does not get the bits of minutes.
  const double duration_s = std::clamp(elapsed_s, 1.0e-3, 1.0);
  const auto duration = static_cast<unsigned long>(std::lround(duration_s * kTicksPerSecond));
  now_ += static_cast<vpx_codec_pts_t>(duration);
  const vpx_enc_frame_flags_t flags = key ? VPX_EFLAG_FORCE_KF : 0;
  if (vpx_codec_encode(&codec_, image_, now_, duration, flags, VPX_DL_REALTIME) != VPX_CODEC_OK) {
    return encoding_failed(vpx_codec_error(&codec_));
  }
  vpx_codec_iter_t iterator = nullptr;
  while (const vpx_codec_cx_pkt_t* packet = vpx_codec_get_cx_data(&codec_, &iterator)) {
    if (packet->kind != VPX_CODEC_CX_FRAME_PKT) continue;
    const auto* bytes = static_cast<const std::uint8_t*>(packet->data.frame.buf);
    frame.insert(frame.end(), bytes, bytes + packet->data.frame.sz);
  }
  return frame.empty() ? encoding_failed("no frame came out") : Status{};
}

}  // namespace

bool video_available() {
  return true;
}

Status make_video_encoder(const VideoOptions& options, std::unique_ptr<VideoEncoder>& encoder) {
  encoder.reset();
  if (options.width < 1 || options.height < 1 ||
      static_cast<std::int64_t>(options.width) * options.height > kMaxVideoPixels) {
    return {StatusCode::kInvalidArgument, "SIZE_OUT_OF_RANGE",
            std::to_string(options.width) + " x " + std::to_string(options.height) + " pixels; video has at most " +
                std::to_string(kMaxVideoPixels),
            "width"};
  }
  auto made = std::make_unique<Vp8Encoder>();
  Status status = made->open(options);
  if (status.ok()) encoder = std::move(made);
  return status;
}

}  // namespace kerf::render
