#include "client/load/viewer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <thread>
#include <utility>

#include "client/cpp/client.h"
#include "client/cpp/credentials.h"
#include "client/cpp/failure.h"
#include "client/load/endpoint.h"

namespace kerf::load {
namespace {

// Returns times one tick apart, beginning when the reader opens: the start of counting is not known yet.
Schedule shown_times(const Plan& plan, Nanoseconds opened) {
  return {opened, Nanoseconds(std::llround(1.0e9 / plan.tick_rate_hz))};
}

std::int64_t unix_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

class FrameViewer : public Viewer {
 public:
  FrameViewer(const Plan& plan, Watching watching, Recorder& recorder, Waiter& waiter)
      : plan_(plan),
        watching_(std::move(watching)),
        waiter_(waiter),
        client_(connect_to(watching_.address, plan, client::Client::Connection::kOwn)),
        watcher_(client_),
        log_(plan, watching_, recorder),
        thread_([this] { run(); }) {}
  ~FrameViewer() override {
    stop();
    thread_.join();
  }
  void stop() override { watcher_.stop(); }

 private:
  void run() {
    std::int64_t frames = 0;
    bool over = false;
    client_.wait_until_connected(kConnectWithin);
    const grpc::Status status =
        watcher_.run(watching_.sheet, options_of(plan_, watching_.role),
                     [&](const v1::Frame& frame, const client::Mirror& /*mirror*/) {
                       log_.seen(frame.tick(), frame.topology_version(), frame.stats(),
                                 static_cast<std::int64_t>(frame.ByteSizeLong()), frame.base_tick() < 0);
                       const Nanoseconds hold = hold_of(plan_, watching_.role, ++frames);
                       over = hold > Nanoseconds(0) && !waiter_.wait_until(waiter_.now() + hold);
                       return !over;
                     });
    log_.finish();
    if (over) return;
    if (watcher_.ended().reason() != v1::Ended::REASON_UNSPECIFIED) {
      log_.ended(v1::Ended::Reason_Name(watcher_.ended().reason()));
    } else if (!status.ok()) {
      log_.ended(client::reason_of(status));
    }
  }

  const Plan& plan_;
  const Watching watching_;
  Waiter& waiter_;
  client::Client client_;
  client::Watcher watcher_;
  ReaderLog log_;
  std::thread thread_;
};

}  // namespace

ReaderLog::ReaderLog(const Plan& plan, const Watching& watching, Recorder& recorder)
    : watching_(watching), recorder_(recorder), opened_(now()), shown_(shown_times(plan, opened_)) {}

void ReaderLog::seen(std::int64_t tick, std::int32_t topology_version, const v1::FrameStats& stats, std::int64_t bytes,
                     bool keyframe) {
  const Nanoseconds decoded = now();
  const std::int64_t age_us = std::max<std::int64_t>(unix_us() - stats.published_unix_us(), 0);
  if (!joined_) recorder_.joined(watching_.role, decoded - opened_);
  joined_ = true;
  recorder_.frame(watching_.role, {decoded, age_us, bytes, stats.skipped(), keyframe});
  shown_.frame(decoded, std::chrono::microseconds(age_us), !stats.sleeping() && !stats.paused(),
               [this](Nanoseconds time, std::int64_t age) { shown(time, age); });
  if (watching_.tracker != nullptr) watching_.tracker->frame(watching_.index, tick, topology_version, decoded);
}

void ReaderLog::finish() {
  shown_.finish(now(), [this](Nanoseconds time, std::int64_t age_us) { shown(time, age_us); });
}

void ReaderLog::shown(Nanoseconds time, std::int64_t age_us) {
  if (recorder_.counts(time)) recorder_.shown(watching_.role, age_us);
}

client::Client connect_to(const std::string& address, const Plan& plan, client::Client::Connection connection) {
  client::Secrets secrets = plan.secrets;
  const std::optional<Endpoint> server = parse_endpoint(plan.server);
  // A proxy shows the certificate of the server behind it.
  if (address != plan.server && secrets.tls_name.empty() && server) secrets.tls_name = server->host;
  return client::Client(client::open_channel(address, secrets, connection));
}

client::WatchOptions options_of(const Plan& plan, Role role) {
  client::WatchOptions options;
  options.reopening.when_slow = false;  // The number of readers ended by the server is a result.
  if (role == Role::kViewer) options.max_rate_hz = plan.viewer_rate_hz;
  return options;
}

Nanoseconds hold_of(const Plan& plan, Role role, std::int64_t frame) {
  const auto nanoseconds = [](double seconds) { return Nanoseconds(std::llround(1.0e9 * seconds)); };
  if (role == Role::kStalled) return nanoseconds(frame == 1 ? plan.stall_s : 0.0);
  return nanoseconds(role == Role::kSlow ? plan.hold_s : 0.0);
}

std::unique_ptr<Viewer> watch_frames(const Plan& plan, const Watching& watching, Recorder& recorder, Waiter& waiter) {
  return std::make_unique<FrameViewer>(plan, watching, recorder, waiter);
}

}  // namespace kerf::load
