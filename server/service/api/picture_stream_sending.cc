#include <algorithm>
#include <string>

#include "kerf/v1/stream.pb.h"
#include "server/service/api/picture_stream.h"
#include "server/service/wire/stream_codec.h"

// Orders and sends the pictures of a PictureStream.
namespace kerf::api {

std::optional<stream::Message> PictureStream::next() {
  Outgoing outgoing = advance();
  stream::Message message;
  if (outgoing.end) {
    message.parts.push_back(std::make_shared<const std::string>(wire::encode_images_ended(*outgoing.end)));
    message.says_too_slow = outgoing.end == wire::EndReason::kTooSlow;
    return message;
  }
  if (!outgoing.data) return std::nullopt;
  message.parts.push_back(
      std::make_shared<const std::string>(wire::encode_image_head(outgoing.image, outgoing.data->size())));
  message.parts.push_back(std::move(outgoing.data));
  return message;
}

std::optional<stream::Bytes> PictureStream::next_picture() {
  Outgoing outgoing = advance();
  if (!outgoing.data) return std::nullopt;
  return std::move(outgoing.data);
}

PictureStream::Outgoing PictureStream::advance() {
  Outgoing outgoing;
  {
    const std::lock_guard lock(mutex_);
    if (over() || !flow_) return outgoing;
    const host::Nanoseconds now = core_->clock.now();
    const stream::FlowControl::Permit permit = flow_->permit(now);
    if (permit.too_slow && !end_) end_ = wire::EndReason::kTooSlow;
    outgoing.end = end_;
    ended_ = end_.has_value();
    if (!ended_ && picture_) {
      outgoing.image = send(*picture_, now);
      outgoing.data = std::move(picture_->data);
      picture_.reset();
    } else if (!ended_) {
      order(permit);
    }
  }
  if (outgoing.end) let_go();
  return outgoing;
}

void PictureStream::order(const stream::FlowControl::Permit& permit) {
  wake_at(permit.wake_at);
  if (!permit.may_send || !feed_ || ordered_) return;
  // Set before the check: a publication from here on is either seen by the check or finds wants_picture_ set.
  wants_picture_ = true;
  const stream::Channel::Newest newest = channel_->newest();
  const bool is_new = newest.publication != last_publication_ || look_changed_;
  const bool is_fresh = newest.snapshot && newest.publication > stale_through_;
  if (!is_fresh || !is_new || (wants_strains() && newest.snapshot->strains.empty())) return;
  wants_picture_ = false;
  ordered_ = true;
  look_changed_ = false;
  feed_->order({look_.still, video_, std::exchange(key_wanted_, false),
                [weak = weak_from_this()](Result<picture::FinishedPicture> picture) {
                  if (const auto session = weak.lock()) session->finished(std::move(picture));
                }});
}

void PictureStream::finished(Result<picture::FinishedPicture> picture) {
  if (!picture.ok()) return fail(picture.error());
  {
    const std::lock_guard lock(mutex_);
    ordered_ = false;
    if (over()) return;
    // Drops a picture finished during a pause. The next one is due right after the pause, and must be decodable by
    // itself, because the dropped video frame is missing before it.
    if (paused_) {
      look_changed_ = true;
      key_wanted_ = true;
      return;
    }
    picture_ = std::move(*picture);
  }
  wake_.call();
}

v1::Image PictureStream::send(const picture::FinishedPicture& picture, host::Nanoseconds now) {
  const sheet::Snapshot& snapshot = *picture.snapshot;
  const std::int64_t skipped = last_tick_ < 0 ? 0 : std::max<std::int64_t>(0, snapshot.tick - last_tick_ - 1);
  v1::Image image;
  image.set_sequence(flow_->sent(picture.data->size(), picture.publication - last_publication_, now));
  image.set_tick(snapshot.tick);
  image.set_codec(codec_);
  image.set_key(picture.key);
  image.set_width_px(picture.width);
  image.set_height_px(picture.height);
  *image.mutable_camera() = picture::encode_camera(picture.camera);
  image.set_strain_end(picture.strain_end);
  wire::encode_stats(snapshot.stats, *snapshot.topology, *image.mutable_stats());
  image.mutable_stats()->set_skipped(skipped);
  ++core_->pictures.sent;
  core_->pictures.skipped += skipped;
  last_publication_ = picture.publication;
  last_tick_ = snapshot.tick;
  wake_at(flow_->permit(now).wake_at);
  return image;
}

void PictureStream::wake_at(const std::optional<host::Nanoseconds>& deadline) {
  if (!deadline) return;
  timer_.wake_at(*deadline, [weak = weak_from_this()] {
    const auto session = weak.lock();
    if (!session) return;
    session->timer_.fired();
    session->wake_.call();
  });
}

}  // namespace kerf::api
