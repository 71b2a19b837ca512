#include "server/service/api/watch_stream.h"

#include <string>
#include <utility>

#include "server/service/api/access.h"
#include "server/service/api/flow_request.h"
#include "server/service/api/live_probes.h"
#include "server/service/api/watch_options.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/finite_check.h"
#include "server/service/wire/frame_encoder.h"

namespace kerf::api {

void WatchStream::on_bytes(std::string_view bytes) {
  v1::WatchRequest request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return fail(invalid_argument("MALFORMED_MESSAGE", "this is not a serialised kerf.v1.WatchRequest"));
  }
  on_request(request);
}

void WatchStream::on_request(const v1::WatchRequest& request) {
  const Status turn = check_turn(request.kind_case() != v1::WatchRequest::KIND_NOT_SET, request.has_start(), started(),
                                 "start, ack, grab, drag, release, pace or pointer");
  if (!turn.ok()) return fail(turn.error());
  if (const Status allowed = check_access(caller_, request); !allowed.ok()) return refuse(request, allowed.error());
  switch (request.kind_case()) {
    case v1::WatchRequest::kStart:
      return start(request.start());
    case v1::WatchRequest::kAck:
      return acknowledge(request.ack());
    case v1::WatchRequest::kPace:
      return set_frame_rate(request.pace());
    case v1::WatchRequest::kGrab:
      return submit(request.grab().grab_id(), wire::decode_grab(request.grab()));
    case v1::WatchRequest::kDrag:
      return submit(request.drag().grab_id(), wire::decode_drag(request.drag()));
    case v1::WatchRequest::kRelease:
      return submit(request.release().grab_id(), wire::decode_release(request.release()));
    case v1::WatchRequest::kPointer:
      return point(request.pointer());
    case v1::WatchRequest::KIND_NOT_SET:
      break;
  }
}

void WatchStream::start(const v1::WatchStart& request) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "start.name");
  if (!id.ok()) return fail(id.error());
  const Result<stream::SubscriberOptions> options = decode_options(request, core_->options.limits);
  if (!options.ok()) return fail(options.error());
  Result<std::vector<scene::Probe>> probes = decode_live_probes(request.probes(), "start.");
  if (!probes.ok()) return fail(probes.error());
  {
    const std::lock_guard lock(mutex_);
    has_audience_ = request.audience();
    sheet_id_ = *id;
  }
  if (probes->empty()) return join(*id, *options);
  make_live_probes(
      core_, *id, std::move(*probes), "start.",
      [self = shared_from_this(), options = *options](Result<std::shared_ptr<stream::Meter>> meter) mutable {
        if (!meter.ok()) return self->fail(with_field(meter.error(), self->name_field_));
        options.meter = std::move(*meter);
        self->join(self->sheet_id_, options);
      });
}

void WatchStream::subscribe(const v1::SubscribeRequest& request) {
  name_field_ = "name";
  if (const Status allowed = check_access(caller_, request); !allowed.ok()) return fail(allowed.error());
  const Result<std::string> id = addressed_sheet(*core_, request.name(), name_field_);
  if (!id.ok()) return fail(id.error());
  const Result<stream::SubscriberOptions> options = decode_options(request, core_->options.limits);
  if (!options.ok()) return fail(options.error());
  if (request.max_frames() > 0) frames_left_ = request.max_frames();
  join(*id, *options);
}

void WatchStream::join(const std::string& sheet_id, const stream::SubscriberOptions& options) {
  Result<std::shared_ptr<const void>> place = open_stream(*core_, caller_, false);
  if (!place.ok()) return fail(place.error());
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    sheet_id_ = sheet_id;
    place_ = std::move(*place);
  }
  const auto self = shared_from_this();
  const std::weak_ptr<WatchStream> weak = self;
  const auto ready = [weak] {
    if (const auto session = weak.lock()) session->wake_.call();
  };
  core_->hub.join(
      sheet_id,
      [options, ready](const std::shared_ptr<stream::Channel>& channel) -> Result<std::shared_ptr<stream::Reader>> {
        KERF_TRY_ASSIGN(std::shared_ptr<stream::Subscriber> subscriber, channel->subscribe(options, ready));
        return std::shared_ptr<stream::Reader>(std::move(subscriber));
      },
      [self](const Result<std::shared_ptr<stream::Reader>>& reader) { self->joined(reader); });
}

void WatchStream::joined(const Result<std::shared_ptr<stream::Reader>>& reader) {
  if (!reader.ok()) return fail(with_field(reader.error(), name_field_));
  const auto subscriber = std::static_pointer_cast<stream::Subscriber>(*reader);  // Made by join().
  for (;;) {
    std::optional<FrameRate> rate;
    {
      const std::lock_guard lock(mutex_);
      if (over()) break;
      rate = std::exchange(early_rate_, {});
      if (!rate) subscriber_ = subscriber;
    }
    if (!rate) return take_seat();
    if (subscriber->set_frame_rate(rate->max_rate_hz, rate->paused, core_->clock.now())) {
      core_->hub.refresh(sheet_id_, subscriber->channel());
    }
  }
  core_->hub.leave(sheet_id_, *subscriber);
}

void WatchStream::take_seat() {
  std::function<void()> wake;
  if (wants_audience()) {
    wake = [weak = weak_from_this()] {
      if (const auto session = weak.lock()) session->wake_.call();
    };
  }
  std::shared_ptr<Audience::Seat> seat = core_->audience->join(sheet_id_, caller_, false, std::move(wake));
  {
    const std::lock_guard lock(mutex_);
    if (!over()) seat_.swap(seat);
  }
  wake_.call();
}

bool WatchStream::wants_audience() const {
  const std::lock_guard lock(mutex_);
  return has_audience_;
}

void WatchStream::point(const v1::Pointer& pointer) {
  if (const Status finite = wire::check_finite(pointer); !finite.ok()) return fail(finite.error());
  std::shared_ptr<Audience::Seat> seat;
  {
    const std::lock_guard lock(mutex_);
    seat = seat_;
  }
  if (seat) seat->point(pointer);
}

std::shared_ptr<stream::Subscriber> WatchStream::joined_subscriber() {
  const std::lock_guard lock(mutex_);
  return over() ? nullptr : subscriber_;
}

void WatchStream::acknowledge(const v1::WatchAck& ack) {
  const std::shared_ptr<stream::Subscriber> subscriber = joined_subscriber();
  if (!subscriber) {
    return fail(invalid_argument("ACK_OUT_OF_RANGE", "a frame was acknowledged before any was sent", "ack.sequence"));
  }
  const Status status = subscriber->acknowledge(ack.sequence(), core_->clock.now(), held_of(ack));
  if (!status.ok()) fail(status.error());
}

void WatchStream::set_frame_rate(const v1::WatchPace& pace) {
  const Result<double> rate = decode_rate(pace.max_rate_hz(), kMaxRateHz, "every tick", "pace.max_rate_hz");
  if (!rate.ok()) return fail(rate.error());
  std::shared_ptr<stream::Subscriber> subscriber;
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    subscriber = subscriber_;
    if (!subscriber) early_rate_ = FrameRate{*rate, pace.paused()};
  }
  if (subscriber && subscriber->set_frame_rate(*rate, pace.paused(), core_->clock.now())) {
    core_->hub.refresh(sheet_id_, subscriber->channel());
  }
}

std::optional<stream::Message> WatchStream::next() {
  std::shared_ptr<stream::Subscriber> subscriber;
  std::shared_ptr<Audience::Seat> seat;
  {
    const std::lock_guard lock(mutex_);
    if (over() || done_) return std::nullopt;
    if (!rejections_.empty()) {
      stream::Message message = std::move(rejections_.front());
      rejections_.pop_front();
      return message;
    }
    subscriber = subscriber_;
    if (has_audience_) seat = seat_;
  }
  if (!subscriber) return std::nullopt;
  if (const Status valid = caller_->check(); !valid.ok()) {
    fail(valid.error());
    return std::nullopt;
  }
  stream::Subscriber::Next next = subscriber->next(core_->clock.now());
  if (next.wake_at) wake_at(*next.wake_at);
  if (next.wants_snapshot) core_->hub.refresh(sheet_id_, subscriber->channel());
  if (next.message) {
    count_frame();
    return std::move(next.message);
  }
  // Frames come first; there is always a time when none is due.
  const std::optional<v1::WatchResponse> news = seat ? seat->next() : std::nullopt;
  if (!news) return std::nullopt;
  return stream::Message{{std::make_shared<const std::string>(news->SerializeAsString())}};
}

void WatchStream::count_frame() {
  const std::lock_guard lock(mutex_);
  if (frames_left_ && --*frames_left_ == 0) done_ = true;
}

void WatchStream::wake_at(host::Nanoseconds deadline) {
  timer_.wake_at(deadline, [weak = weak_from_this()] {
    const auto session = weak.lock();
    if (!session) return;
    session->timer_.fired();
    session->wake_.call();
  });
}

void WatchStream::set_wake(std::function<void()> wake) {
  const bool listens = static_cast<bool>(wake);
  wake_.set(std::move(wake));
  if (listens) wake_.call();
}

bool WatchStream::ended() const {
  const std::lock_guard lock(mutex_);
  return over() || done_ || (subscriber_ && subscriber_->ended());
}

std::optional<Error> WatchStream::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

bool WatchStream::started() const {
  const std::lock_guard lock(mutex_);
  return !sheet_id_.empty();
}

void WatchStream::fail(Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (over() || (subscriber_ && subscriber_->ended())) return;
    failure_ = std::move(error);
  }
  wake_.call();
}

void WatchStream::server_stops() {
  if (!started()) fail(server_stopping());
}

void WatchStream::check_caller() {
  if (const Status valid = caller_->check(); !valid.ok()) fail(valid.error());
}

void WatchStream::close() {
  std::shared_ptr<stream::Subscriber> subscriber;
  std::shared_ptr<Audience::Seat> seat;
  std::shared_ptr<const void> place;
  std::set<std::string> grabs;
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    closed_ = true;
    subscriber = std::move(subscriber_);
    seat.swap(seat_);
    place.swap(place_);
    grabs.swap(held_grabs_);
  }
  timer_.stop();
  core_->streams.remove(*this);
  --core_->num_watchers;
  if (subscriber) core_->hub.leave(sheet_id_, *subscriber);
  for (const std::string& grab_id : grabs) core_->host.release_grab(sheet_id_, grab_id);
}

std::shared_ptr<WatchSession> make_watch_session(const std::shared_ptr<ApiCore>& core,
                                                 const Result<auth::Caller>& caller) {
  auto session = std::make_shared<WatchStream>(core, caller.ok() ? *caller : auth::everybody());
  core->streams.add(session);
  if (!caller.ok()) session->fail(caller.error());
  if (core->stopping) session->server_stops();
  return session;
}

std::shared_ptr<WatchSession> make_subscription(const std::shared_ptr<ApiCore>& core,
                                                const Result<auth::Caller>& caller,
                                                const v1::SubscribeRequest& request) {
  auto session = std::static_pointer_cast<WatchStream>(make_watch_session(core, caller));
  session->subscribe(request);
  return session;
}

}  // namespace kerf::api
