#include "server/service/api/session.h"

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kerf/v1/stream.pb.h"
#include "server/service/api/access.h"
#include "server/service/api/flow_request.h"
#include "server/service/api/open_streams.h"
#include "server/service/api/watch_options.h"
#include "server/service/host/wake_callback.h"
#include "server/service/host/wake_timer.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/frame_encoder.h"

namespace kerf::api {
namespace {

// Limit on rejections that the client has not read. A client that reads never reaches it; those of a client that does
// not read would only cost memory.
constexpr std::size_t kMaxUnreadRejections = 256;

class Session final : public WatchSession, public OpenStream, public std::enable_shared_from_this<Session> {
 public:
  Session(std::shared_ptr<ApiCore> core, auth::Caller caller)
      : core_(std::move(core)), caller_(std::move(caller)), timer_(core_->clock) {
    ++core_->num_watchers;
  }
  ~Session() override { close(); }

  void on_request(const v1::WatchRequest& request) override;
  void on_bytes(std::string_view bytes) override;
  std::optional<stream::Message> next() override;
  void set_wake(std::function<void()> wake) override;
  [[nodiscard]] bool ended() const override;
  [[nodiscard]] std::optional<Error> failure() const override;
  void close() override;
  void server_stops() override;
  void check_caller() override;

  // Begins a stream that takes no requests.
  void subscribe(const v1::SubscribeRequest& request);
  // Ends the stream with `error`, unless it has ended already.
  void fail(Error error);
  [[nodiscard]] bool started() const;

 private:
  struct FrameRate {
    double max_rate_hz;
    bool paused;
  };

  void refuse(const v1::WatchRequest& request, const Error& error);
  void start(const v1::WatchStart& request);
  void join(const std::string& sheet_id, const stream::SubscriberOptions& options);
  void set_frame_rate(const v1::WatchPace& pace);
  std::shared_ptr<stream::Subscriber> joined_subscriber();
  void joined(const Result<std::shared_ptr<stream::Reader>>& reader);
  void acknowledge(const v1::WatchAck& ack);
  void submit(const std::string& grab_id, Result<scene::Command> command);
  void answered(const std::string& grab_id, const scene::Command& command, const Status& status);
  void reject(const std::string& grab_id, const Error& error);
  void count_frame();
  void wake_at(host::Nanoseconds deadline);
  [[nodiscard]] bool over() const { return closed_ || failure_; }  // Needs mutex_ held.

  const std::shared_ptr<ApiCore> core_;
  const auth::Caller caller_;
  host::WakeCallback wake_;
  host::WakeTimer timer_;
  const char* name_field_ = "start.name";  // Field of the request that began the stream.

  mutable std::mutex mutex_;  // Guards the members below; not held over calls to the host, the hub or the subscriber.
  std::string sheet_id_;      // Empty until started.
  std::shared_ptr<stream::Subscriber> subscriber_;
  std::optional<FrameRate> early_rate_;  // Received before the stream joined; applied to subscriber_ then.
  std::deque<stream::Message> rejections_;
  std::set<std::string> held_grabs_;  // Grabs made by this stream and not yet released.
  std::optional<Error> failure_;
  std::optional<std::int32_t> frames_left_;  // Frames until the stream ends; empty: no limit.
  bool done_ = false;                        // The last of a limited number of frames was given.
  bool closed_ = false;
};

void Session::on_bytes(std::string_view bytes) {
  v1::WatchRequest request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return fail(invalid_argument("MALFORMED_MESSAGE", "this is not a serialised kerf.v1.WatchRequest"));
  }
  on_request(request);
}

void Session::on_request(const v1::WatchRequest& request) {
  const Status turn = check_turn(request.kind_case() != v1::WatchRequest::KIND_NOT_SET, request.has_start(), started(),
                                 "start, ack, grab, drag, release or pace");
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
    case v1::WatchRequest::KIND_NOT_SET:
      break;
  }
}

// A hand that is not allowed is rejected as others are; the stream stays.
void Session::refuse(const v1::WatchRequest& request, const Error& error) {
  if (error.reason != "SCOPE_TOO_LOW") return fail(error);
  if (request.has_grab()) return reject(request.grab().grab_id(), error);
  if (request.has_drag()) return reject(request.drag().grab_id(), error);
  reject(request.release().grab_id(), error);
}

void Session::start(const v1::WatchStart& request) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "start.name");
  if (!id.ok()) return fail(id.error());
  const Result<stream::SubscriberOptions> options = decode_options(request, core_->options.limits);
  if (!options.ok()) return fail(options.error());
  join(*id, *options);
}

void Session::subscribe(const v1::SubscribeRequest& request) {
  name_field_ = "name";
  if (const Status allowed = check_access(caller_, request); !allowed.ok()) return fail(allowed.error());
  const Result<std::string> id = addressed_sheet(*core_, request.name(), name_field_);
  if (!id.ok()) return fail(id.error());
  const Result<stream::SubscriberOptions> options = decode_options(request, core_->options.limits);
  if (!options.ok()) return fail(options.error());
  if (request.max_frames() > 0) frames_left_ = request.max_frames();
  join(*id, *options);
}

void Session::join(const std::string& sheet_id, const stream::SubscriberOptions& options) {
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    sheet_id_ = sheet_id;
  }
  const auto self = shared_from_this();
  const std::weak_ptr<Session> weak = self;
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

void Session::joined(const Result<std::shared_ptr<stream::Reader>>& reader) {
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
    if (!rate) return wake_.call();
    if (subscriber->set_frame_rate(rate->max_rate_hz, rate->paused, core_->clock.now())) {
      core_->hub.refresh(sheet_id_, subscriber->channel());
    }
  }
  core_->hub.leave(sheet_id_, *subscriber);
}

std::shared_ptr<stream::Subscriber> Session::joined_subscriber() {
  const std::lock_guard lock(mutex_);
  return over() ? nullptr : subscriber_;
}

void Session::acknowledge(const v1::WatchAck& ack) {
  const std::shared_ptr<stream::Subscriber> subscriber = joined_subscriber();
  if (!subscriber) {
    return fail(invalid_argument("ACK_OUT_OF_RANGE", "a frame was acknowledged before any was sent", "ack.sequence"));
  }
  const Status status = subscriber->acknowledge(ack.sequence(), core_->clock.now(), held_of(ack));
  if (!status.ok()) fail(status.error());
}

void Session::set_frame_rate(const v1::WatchPace& pace) {
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

void Session::submit(const std::string& grab_id, Result<scene::Command> command) {
  if (!command.ok()) return reject(grab_id, command.error());
  core_->host.submit(
      sheet_id_, *command,
      [self = shared_from_this(), grab_id, command = *command](Result<host::CommandResult> result) {
        self->answered(grab_id, command, result.ok() ? Status(Nothing{}) : Status(result.error()));
      },
      nullptr, true);
}

void Session::answered(const std::string& grab_id, const scene::Command& command, const Status& status) {
  if (!status.ok()) return reject(grab_id, status.error());
  bool too_late = false;
  {
    const std::lock_guard lock(mutex_);
    if (std::holds_alternative<scene::Release>(command)) held_grabs_.erase(grab_id);
    if (std::holds_alternative<scene::Grab>(command)) {
      too_late = over();
      if (!too_late) held_grabs_.insert(grab_id);
    }
  }
  if (too_late) core_->host.release_grab(sheet_id_, grab_id);
}

void Session::reject(const std::string& grab_id, const Error& error) {
  bool flooded = false;
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    flooded = rejections_.size() == kMaxUnreadRejections;
    if (!flooded) {
      stream::Message message;
      message.parts.push_back(std::make_shared<const std::string>(wire::encode_rejection(grab_id, error)));
      rejections_.push_back(std::move(message));
    }
  }
  if (flooded) {
    return fail(resource_exhausted("TOO_MANY_REJECTIONS",
                                   std::to_string(kMaxUnreadRejections) + " rejections are unread; read the stream"));
  }
  wake_.call();
}

std::optional<stream::Message> Session::next() {
  std::shared_ptr<stream::Subscriber> subscriber;
  {
    const std::lock_guard lock(mutex_);
    if (over() || done_) return std::nullopt;
    if (!rejections_.empty()) {
      stream::Message message = std::move(rejections_.front());
      rejections_.pop_front();
      return message;
    }
    subscriber = subscriber_;
  }
  if (!subscriber) return std::nullopt;
  if (const Status valid = caller_->check(); !valid.ok()) {
    fail(valid.error());
    return std::nullopt;
  }
  stream::Subscriber::Next next = subscriber->next(core_->clock.now());
  if (next.wake_at) wake_at(*next.wake_at);
  if (next.message) count_frame();
  return std::move(next.message);
}

void Session::count_frame() {
  const std::lock_guard lock(mutex_);
  if (frames_left_ && --*frames_left_ == 0) done_ = true;
}

void Session::wake_at(host::Nanoseconds deadline) {
  timer_.wake_at(deadline, [weak = weak_from_this()] {
    const auto session = weak.lock();
    if (!session) return;
    session->timer_.fired();
    session->wake_.call();
  });
}

void Session::set_wake(std::function<void()> wake) {
  const bool listens = static_cast<bool>(wake);
  wake_.set(std::move(wake));
  if (listens) wake_.call();
}

bool Session::ended() const {
  const std::lock_guard lock(mutex_);
  return over() || done_ || (subscriber_ && subscriber_->ended());
}

std::optional<Error> Session::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

bool Session::started() const {
  const std::lock_guard lock(mutex_);
  return !sheet_id_.empty();
}

void Session::fail(Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (over() || (subscriber_ && subscriber_->ended())) return;
    failure_ = std::move(error);
  }
  wake_.call();
}

void Session::server_stops() {
  if (!started()) fail(server_stopping());
}

void Session::check_caller() {
  if (const Status valid = caller_->check(); !valid.ok()) fail(valid.error());
}

void Session::close() {
  std::shared_ptr<stream::Subscriber> subscriber;
  std::set<std::string> grabs;
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    closed_ = true;
    subscriber = std::move(subscriber_);
    grabs.swap(held_grabs_);
  }
  timer_.stop();
  core_->streams.remove(*this);
  --core_->num_watchers;
  if (subscriber) core_->hub.leave(sheet_id_, *subscriber);
  for (const std::string& grab_id : grabs) core_->host.release_grab(sheet_id_, grab_id);
}

}  // namespace

std::shared_ptr<WatchSession> make_watch_session(const std::shared_ptr<ApiCore>& core,
                                                 const Result<auth::Caller>& caller) {
  auto session = std::make_shared<Session>(core, caller.ok() ? *caller : auth::everybody());
  core->streams.add(session);
  if (!caller.ok()) session->fail(caller.error());
  if (core->stopping) session->server_stops();
  return session;
}

std::shared_ptr<WatchSession> make_subscription(const std::shared_ptr<ApiCore>& core,
                                                const Result<auth::Caller>& caller,
                                                const v1::SubscribeRequest& request) {
  auto session = std::static_pointer_cast<Session>(make_watch_session(core, caller));
  session->subscribe(request);
  return session;
}

}  // namespace kerf::api
