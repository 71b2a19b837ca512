#include "server/api/session.h"

#include <cmath>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kerf/v1/stream.pb.h"
#include "server/api/ready_signal.h"
#include "server/wire/command_codec.h"
#include "server/wire/frame_encoder.h"

namespace kerf::api {
namespace {

// More than a client that reads can make: it answers nothing and only costs memory.
constexpr std::size_t kMaxUnreadRejections = 256;
constexpr double kMinRateHz = 1.0e-3;  // a frame in a quarter of an hour; far below it, periods overflow
constexpr double kMaxRateHz = 1000.0;

Result<stream::SubscriberOptions> decode_options(const v1::WatchStart& start, const Limits& limits) {
  stream::SubscriberOptions options;
  if (start.window() != 0) options.window = start.window();
  if (options.window < 1 || options.window > stream::kMaxWindow) {
    return invalid_argument("OUT_OF_RANGE",
                            "start.window is " + std::to_string(start.window()) + "; must be 1 to 8, or 0 for 2",
                            "start.window");
  }
  const double rate_hz = start.max_rate_hz();
  if (rate_hz != 0.0 && !(rate_hz >= kMinRateHz && rate_hz <= kMaxRateHz)) {  // also refuses NaN
    return invalid_argument(
        "OUT_OF_RANGE",
        "start.max_rate_hz is " + std::to_string(rate_hz) + "; must be 0.001 to 1000, or 0 for every tick",
        "start.max_rate_hz");
  }
  options.max_rate_hz = rate_hz;
  switch (start.encoding()) {
    case v1::ENCODING_UNSPECIFIED:
    case v1::COMPACT:
      options.encoding = wire::Encoding::kCompact;
      break;
    case v1::RAW:
      options.encoding = wire::Encoding::kRaw;
      break;
    default:
      return invalid_argument("OUT_OF_RANGE",
                              "start.encoding is " + std::to_string(start.encoding()) +
                                  "; must be COMPACT (1) or RAW (2), or 0 for COMPACT",
                              "start.encoding");
  }
  options.max_unacknowledged_bytes = static_cast<std::size_t>(limits.max_unsent_bytes_per_subscriber);
  options.ack_timeout = limits.watch_ack_timeout;
  return options;
}

class Session final : public WatchSession, public std::enable_shared_from_this<Session> {
 public:
  explicit Session(std::shared_ptr<ApiCore> core) : core_(std::move(core)) { ++core_->num_watchers; }
  ~Session() override { close(); }

  void on_request(const v1::WatchRequest& request) override;
  void on_bytes(std::string_view bytes) override;
  std::optional<stream::Message> next() override;
  void set_ready(std::function<void()> ready) override;
  [[nodiscard]] bool ended() const override;
  [[nodiscard]] std::optional<Error> failure() const override;
  void close() override;

  // The stream is refused with `error`, unless it has ended already.
  void fail(Error error);
  [[nodiscard]] bool started() const;

 private:
  void start(const v1::WatchStart& request);
  void joined(Result<std::shared_ptr<stream::Subscriber>> subscriber);
  void acknowledge(const v1::WatchAck& ack);
  void submit(const std::string& grab_id, Result<sheet::Command> command);
  void answered(const std::string& grab_id, const sheet::Command& command, const Status& status);
  void reject(const std::string& grab_id, const Error& error);
  void wake_at(host::Nanoseconds deadline);
  void on_timer();
  [[nodiscard]] bool over() const { return closed_ || failure_; }  // mutex_ held

  const std::shared_ptr<ApiCore> core_;
  ReadySignal ready_;

  mutable std::mutex mutex_;  // of what follows; not held over calls to the host, the hub or the subscriber
  std::string sheet_id_;      // empty until started
  std::shared_ptr<stream::Subscriber> subscriber_;
  std::deque<stream::Message> rejections_;
  std::set<std::string> held_grabs_;
  std::optional<Error> failure_;
  std::optional<std::pair<host::Nanoseconds, host::TimerId>> timer_;
  bool closed_ = false;
};

void Session::on_bytes(std::string_view bytes) {
  v1::WatchRequest request;
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return fail(invalid_argument("MALFORMED_MESSAGE", "this is no serialised kerf.v1.WatchRequest"));
  }
  on_request(request);
}

void Session::on_request(const v1::WatchRequest& request) {
  const bool is_start = request.kind_case() == v1::WatchRequest::kStart;
  if (request.kind_case() == v1::WatchRequest::KIND_NOT_SET) {
    return fail(invalid_argument("CHOICE_MISSING", "kind must be one of start, ack, grab, drag or release", "kind"));
  }
  if (is_start == started()) {
    return fail(is_start ? invalid_argument("STARTED_TWICE", "this stream was started before; open another", "start")
                         : invalid_argument("START_MISSING", "the first message of a stream must be start", "start"));
  }
  switch (request.kind_case()) {
    case v1::WatchRequest::kStart:
      return start(request.start());
    case v1::WatchRequest::kAck:
      return acknowledge(request.ack());
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

void Session::start(const v1::WatchStart& request) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "start.name");
  if (!id.ok()) return fail(id.error());
  const Result<stream::SubscriberOptions> options = decode_options(request, core_->options.limits);
  if (!options.ok()) return fail(options.error());
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    sheet_id_ = *id;
  }
  const auto self = shared_from_this();
  const std::weak_ptr<Session> weak = self;
  const auto ready = [weak] {
    if (const auto session = weak.lock()) session->ready_.raise();
  };
  core_->hub.join(*id, *options, ready, [self](Result<std::shared_ptr<stream::Subscriber>> subscriber) {
    self->joined(std::move(subscriber));
  });
}

void Session::joined(Result<std::shared_ptr<stream::Subscriber>> subscriber) {
  if (!subscriber.ok()) return fail(at_field(subscriber.error(), "start.name"));
  bool unwanted = false;
  {
    const std::lock_guard lock(mutex_);
    unwanted = over();
    if (!unwanted) subscriber_ = *subscriber;
  }
  if (unwanted) return core_->hub.leave(sheet_id_, **subscriber);
  ready_.raise();
}

void Session::acknowledge(const v1::WatchAck& ack) {
  std::shared_ptr<stream::Subscriber> subscriber;
  {
    const std::lock_guard lock(mutex_);
    if (over()) return;
    subscriber = subscriber_;
  }
  if (!subscriber) {
    return fail(invalid_argument("ACK_OUT_OF_RANGE", "a frame is acknowledged before one was sent", "ack.sequence"));
  }
  if (const Status status = subscriber->acknowledge(ack.sequence()); !status.ok()) fail(status.error());
}

void Session::submit(const std::string& grab_id, Result<sheet::Command> command) {
  if (!command.ok()) return reject(grab_id, command.error());
  core_->host.submit(sheet_id_, *command,
                     [self = shared_from_this(), grab_id, command = *command](Result<host::CommandResult> result) {
                       self->answered(grab_id, command, result.ok() ? Status(Nothing{}) : Status(result.error()));
                     });
}

void Session::answered(const std::string& grab_id, const sheet::Command& command, const Status& status) {
  if (!status.ok()) return reject(grab_id, status.error());
  bool too_late = false;
  {
    const std::lock_guard lock(mutex_);
    if (std::holds_alternative<sheet::Release>(command)) held_grabs_.erase(grab_id);
    if (std::holds_alternative<sheet::Grab>(command)) {
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
    return fail({ErrorCode::kResourceExhausted,
                 "TOO_MANY_REJECTIONS",
                 std::to_string(kMaxUnreadRejections) + " rejections wait to be read; read the stream",
                 {}});
  }
  ready_.raise();
}

std::optional<stream::Message> Session::next() {
  std::shared_ptr<stream::Subscriber> subscriber;
  {
    const std::lock_guard lock(mutex_);
    if (over()) return std::nullopt;
    if (!rejections_.empty()) {
      stream::Message message = std::move(rejections_.front());
      rejections_.pop_front();
      return message;
    }
    subscriber = subscriber_;
  }
  if (!subscriber) return std::nullopt;
  stream::Subscriber::Next next = subscriber->next(core_->clock.now());
  if (next.wake_at) wake_at(*next.wake_at);
  return std::move(next.message);
}

// One timer at a time: an earlier one stays, and asks for the later when it has fired in vain.
void Session::wake_at(host::Nanoseconds deadline) {
  const std::lock_guard lock(mutex_);
  if (over() || (timer_ && timer_->first <= deadline)) return;
  if (timer_) core_->clock.cancel(timer_->second);
  const std::weak_ptr<Session> weak = weak_from_this();
  const host::TimerId timer = core_->clock.schedule(deadline, [weak] {
    if (const auto session = weak.lock()) session->on_timer();
  });
  timer_ = {deadline, timer};
}

void Session::on_timer() {
  {
    const std::lock_guard lock(mutex_);
    timer_.reset();
  }
  ready_.raise();
}

void Session::set_ready(std::function<void()> ready) {
  const bool listens = static_cast<bool>(ready);
  ready_.set(std::move(ready));
  if (listens) ready_.raise();
}

bool Session::ended() const {
  const std::lock_guard lock(mutex_);
  return over() || (subscriber_ && subscriber_->ended());
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
  ready_.raise();
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
    if (timer_) core_->clock.cancel(timer_->second);
  }
  {
    const std::lock_guard lock(core_->sessions_mutex);
    core_->sessions.erase(this);
  }
  --core_->num_watchers;
  if (subscriber) core_->hub.leave(sheet_id_, *subscriber);
  for (const std::string& grab_id : grabs) core_->host.release_grab(sheet_id_, grab_id);
}

}  // namespace

std::shared_ptr<WatchSession> make_watch_session(const std::shared_ptr<ApiCore>& core) {
  auto session = std::make_shared<Session>(core);
  {
    const std::lock_guard lock(core->sessions_mutex);
    core->sessions[session.get()] = session;
  }
  if (core->stopping) session->fail(server_stopping());
  return session;
}

void refuse_unstarted_sessions(ApiCore& core) {
  std::vector<std::shared_ptr<WatchSession>> sessions;
  {
    const std::lock_guard lock(core.sessions_mutex);
    for (const auto& [address, weak] : core.sessions) {
      if (auto session = weak.lock()) sessions.push_back(std::move(session));
    }
  }
  for (const auto& each : sessions) {
    auto& session = static_cast<Session&>(*each);
    if (!session.started()) session.fail(server_stopping());
  }
}

}  // namespace kerf::api
