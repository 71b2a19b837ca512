#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "kerf/v1/stream.pb.h"
#include "server/service/api/audience.h"
#include "server/service/api/core.h"
#include "server/service/api/open_streams.h"
#include "server/service/api/watch_session.h"
#include "server/service/auth/grant.h"
#include "server/service/host/wake_callback.h"
#include "server/service/host/wake_timer.h"

namespace kerf::api {

// Serves one stream of StreamService.Watch or Subscribe: its frames, its hands and its audience.
class WatchStream final : public WatchSession, public OpenStream, public std::enable_shared_from_this<WatchStream> {
 public:
  WatchStream(std::shared_ptr<ApiCore> core, auth::Caller caller)
      : core_(std::move(core)), caller_(std::move(caller)), timer_(core_->clock) {
    ++core_->num_watchers;
  }
  ~WatchStream() override { close(); }

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
  void point(const v1::Pointer& pointer);
  void take_seat();
  [[nodiscard]] bool wants_audience() const;
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
  bool has_audience_ = false;             // It wants the messages of `seat_`.
  std::shared_ptr<Audience::Seat> seat_;  // Set once it has joined.
  std::shared_ptr<const void> place_;     // Among the streams of its tenant.
  std::set<std::string> held_grabs_;      // Grabs made by this stream and not yet released.
  std::optional<Error> failure_;
  std::optional<std::int32_t> frames_left_;  // Frames until the stream ends; empty: no limit.
  bool done_ = false;                        // The last of a limited number of frames was given.
  bool closed_ = false;
};

// `caller`: who watches. If it is an error, the stream has failed with it.
std::shared_ptr<WatchSession> make_watch_session(const std::shared_ptr<ApiCore>& core,
                                                 const Result<auth::Caller>& caller);

// Returns a started session of StreamService.Subscribe, which takes no requests.
std::shared_ptr<WatchSession> make_subscription(const std::shared_ptr<ApiCore>& core,
                                                const Result<auth::Caller>& caller,
                                                const v1::SubscribeRequest& request);

}  // namespace kerf::api
