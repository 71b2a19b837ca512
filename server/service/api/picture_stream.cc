#include "server/service/api/picture_stream.h"

#include <string>
#include <utility>

#include "kerf/v1/stream.pb.h"
#include "server/service/api/access.h"
#include "server/service/api/flow_request.h"
#include "server/service/wire/finite_check.h"

// Handles the requests to a PictureStream, its start and its end.
namespace kerf::api {

void PictureStream::on_bytes(std::string_view bytes) {
  v1::WatchImagesRequest request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return fail(invalid_argument("MALFORMED_MESSAGE", "this is not a serialised kerf.v1.WatchImagesRequest"));
  }
  if (const Status finite = wire::check_finite(request); !finite.ok()) return fail(finite.error());
  const Status turn = check_turn(request.kind_case() != v1::WatchImagesRequest::KIND_NOT_SET, request.has_start(),
                                 started(), "start, ack, view or pace");
  if (!turn.ok()) return fail(turn.error());
  if (const Status allowed = check_access(caller_, request); !allowed.ok()) return fail(allowed.error());
  switch (request.kind_case()) {
    case v1::WatchImagesRequest::kStart:
      return start(request.start(), true);
    case v1::WatchImagesRequest::kAck:
      return acknowledge(request.ack());
    case v1::WatchImagesRequest::kView:
      return look(request.view());
    case v1::WatchImagesRequest::kPace:
      return set_frame_rate(request.pace());
    case v1::WatchImagesRequest::KIND_NOT_SET:
      break;
  }
}

void PictureStream::start(const v1::WatchImagesStart& request, bool acknowledges) {
  Result<std::string> id = addressed_sheet(*core_, request.name(), "start.name");
  if (!id.ok()) return fail(id.error());
  Result<ImageRequest> wanted = decode_image_request(request, core_->options.limits);
  if (!wanted.ok()) return fail(wanted.error());
  if (const Status status = check_renderer(*core_); !status.ok()) return fail(status.error());
  Result<std::shared_ptr<const void>> place = open_stream(*core_, caller_, true);
  if (!place.ok()) return fail(place.error());
  const std::int32_t limit = core_->options.limits.max_image_streams;
  bool admitted = false;
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    started_ = true;
    admitted = ++core_->num_image_streams <= limit;
    counted_ = true;
    place_ = std::move(*place);
    sheet_id_ = std::move(*id);
    codec_ = wanted->codec;
    wanted->flow.acknowledges = acknowledges;
    flow_.emplace(wanted->flow);
    take_look(wanted->look);
  }
  if (admitted) return join();
  fail(resource_exhausted("TOO_MANY_IMAGE_STREAMS", "this server has " + std::to_string(limit) +
                                                        " image streams, which is its limit; try again later"));
}

void PictureStream::join() {
  const auto self = shared_from_this();
  core_->hub.join(
      sheet_id_,
      [self](const std::shared_ptr<stream::Channel>& channel) -> Result<std::shared_ptr<stream::Reader>> {
        const std::lock_guard lock(self->mutex_);
        KERF_TRY(channel->admit(self, self->wants_strains()));
        if (self->paused_) channel->want_snapshots(*self, false);
        self->channel_ = channel;
        return std::shared_ptr<stream::Reader>(self);
      },
      [self](const Result<std::shared_ptr<stream::Reader>>& reader) {
        self->joined(reader.ok() ? Status(Nothing{}) : Status(reader.error()));
      });
}

void PictureStream::joined(const Status& status) {
  if (!status.ok()) return fail(with_field(status.error(), "start.name"));
  bool unwanted = false;
  std::shared_ptr<Audience::Seat> seat = core_->audience->join(sheet_id_, caller_, true, nullptr);
  {
    const std::lock_guard lock(mutex_);
    unwanted = over();
    joined_ = !unwanted;
    if (joined_) seat_ = std::move(seat);
  }
  if (unwanted) return core_->hub.leave(sheet_id_, *this);
  // Runs after the channel is attached to the sheet. If the sheet is deleted now and its name reused, the channel ends.
  inspect<picture::Backdrop>(
      core_, sheet_id_, picture::backdrop_of, "start.name",
      [self = shared_from_this()](const Result<picture::Backdrop>& backdrop) { self->shown(backdrop); });
}

void PictureStream::shown(const Result<picture::Backdrop>& backdrop) {
  if (!backdrop.ok()) return fail(backdrop.error());
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    backdrop_ = *backdrop;
    feed_ = core_->studio.feed(channel_, *backdrop_, look_.view);
  }
  wake_.call();
}

void PictureStream::acknowledge(const v1::WatchAck& ack) {
  bool opened = false;
  Status status = Nothing{};
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    const Result<bool> settled = flow_->acknowledge(ack.sequence(), core_->clock.now(), held_of(ack));
    if (settled.ok()) {
      opened = *settled;
    } else {
      status = settled.error();
    }
  }
  if (!status.ok()) return fail(status.error());
  if (opened) wake_.call();
}

void PictureStream::look(const v1::ImageView& view) {
  const Result<ImageLook> wanted = decode_look(view, codec_, "view.");
  if (!wanted.ok()) return fail(wanted.error());
  std::shared_ptr<stream::Channel> poorer;  // The channel, if its newest snapshot lacks the strains wanted now.
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    take_look(*wanted);
    if (channel_) {
      const bool had_strains = channel_->wants_strains();
      channel_->want_strains(*this, wants_strains());
      if (wants_strains() && !had_strains) poorer = channel_;
    }
  }
  if (poorer) core_->hub.refresh(sheet_id_, poorer);
  wake_.call();
}

void PictureStream::take_look(const ImageLook& look) {
  if (codec_ == v1::IMAGE_VP8) {
    const bool same_track = video_ && video_->options() == look.video;
    if (same_track && look_.view == look.view) key_wanted_ = true;
    if (!same_track) video_ = std::make_shared<picture::VideoTrack>(look.video);
  }
  look_ = look;
  look_changed_ = true;
  if (backdrop_) feed_ = core_->studio.feed(channel_, *backdrop_, look_.view);
}

void PictureStream::set_frame_rate(const v1::WatchPace& pace) {
  const Result<double> rate = decode_rate(pace.max_rate_hz(), kMaxRateHz, "every tick", "pace.max_rate_hz");
  if (!rate.ok()) return fail(rate.error());
  std::shared_ptr<stream::Channel> stale;
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    const bool goes_on = paused_ && !pace.paused();
    paused_ = pace.paused();
    flow_->set_frame_rate(*rate, paused_, core_->clock.now());
    if (channel_) channel_->want_snapshots(*this, !paused_);
    if (channel_ && goes_on) {
      stale_through_ = channel_->newest_publication();
      stale = channel_;
    }
  }
  if (stale) core_->hub.refresh(sheet_id_, stale);
  wake_.call();
}

void PictureStream::set_wake(std::function<void()> wake) {
  const bool listens = static_cast<bool>(wake);
  wake_.set(std::move(wake));
  if (listens) wake_.call();
}

void PictureStream::wake() {
  if (wants_picture_.exchange(false)) wake_.call();
}

void PictureStream::end(wire::EndReason reason) {
  {
    const std::lock_guard lock(mutex_);
    if (end_ || over()) return;
    end_ = reason;
  }
  wake_.call();
}

void PictureStream::leave() {
  std::shared_ptr<stream::Channel> channel;
  {
    const std::lock_guard lock(mutex_);
    channel = channel_;
  }
  if (channel) channel->leave(*this);
}

bool PictureStream::ended() const {
  const std::lock_guard lock(mutex_);
  return over();
}

std::optional<Error> PictureStream::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

bool PictureStream::started() const {
  const std::lock_guard lock(mutex_);
  return started_;
}

void PictureStream::fail(Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    failure_ = std::move(error);
  }
  let_go();
  wake_.call();
}

void PictureStream::server_stops() {
  if (!started()) fail(server_stopping());
}

void PictureStream::let_go() {
  bool leaves = false;
  bool counted = false;
  std::shared_ptr<Audience::Seat> seat;
  std::shared_ptr<const void> place;
  {
    const std::lock_guard lock(mutex_);
    seat.swap(seat_);
    place.swap(place_);
    leaves = std::exchange(joined_, false);
    counted = std::exchange(counted_, false);
    feed_.reset();
    backdrop_.reset();
    video_.reset();
    picture_.reset();
  }
  timer_.stop();
  if (counted) --core_->num_image_streams;
  if (leaves) core_->hub.leave(sheet_id_, *this);
}

void PictureStream::close() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(closed_, true)) return;
  }
  let_go();
  core_->streams.remove(*this);
}

void PictureStream::check_caller() {
  if (const Status valid = caller_->check(); !valid.ok()) fail(valid.error());
}

std::shared_ptr<ImageSession> make_image_session(const std::shared_ptr<ApiCore>& core,
                                                 const Result<auth::Caller>& caller) {
  auto session = std::make_shared<PictureStream>(core, caller.ok() ? *caller : auth::everybody());
  core->streams.add(session);
  if (!caller.ok()) session->fail(caller.error());
  if (core->stopping) session->server_stops();
  return session;
}

std::shared_ptr<ImageSession> make_image_player(const std::shared_ptr<ApiCore>& core,
                                                const Result<auth::Caller>& caller, const v1::WatchImagesStart& start) {
  auto session = std::static_pointer_cast<PictureStream>(make_image_session(core, caller));
  const Status allowed = caller.ok() ? check_access(*caller, start) : Status(Nothing{});
  if (!allowed.ok()) session->fail(allowed.error());
  session->start(start, false);
  return session;
}

}  // namespace kerf::api
