#include "server/service/picture/video_track.h"

#include <vector>

#include "server/service/picture/picture_view.h"

namespace kerf::picture {

Result<VideoTrack::Frame> VideoTrack::encode(const render::Pixels& pixels, host::Nanoseconds now, bool key) {
  constexpr double kFirstFrameS = 1.0 / 30.0;  // Assumed duration; the true one is unknown.
  double elapsed_s = kFirstFrameS;
  if (encoder_) {
    elapsed_s = host::seconds(now - last_at_);
  } else if (const render::Status made = render::make_video_encoder(options_, encoder_); !made.ok()) {
    return to_error(made);
  }
  std::vector<std::uint8_t> frame;
  const render::Status status = encoder_->encode(pixels, elapsed_s, key, frame);
  if (!status.ok()) return to_error(status);
  last_at_ = now;
  return Frame{std::string(frame.begin(), frame.end()), render::is_key_frame(frame)};
}

}  // namespace kerf::picture
