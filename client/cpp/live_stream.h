#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include "client/cpp/failure.h"
#include "kerf/v1/stream.pb.h"

namespace kerf::client {

// Chooses when an ended stream is reopened, with the same settings.
struct Reopening {
  bool when_slow = true;                   // Reopens a stream that the server ended as TOO_SLOW.
  std::chrono::milliseconds when_lost{0};  // Retries for this long if the server stops or cannot be reached.
};

// Runs a stream whose messages are acknowledged: Watch or WatchImages. Allows one run().
template <typename Request, typename Response>
class LiveStream {
 public:
  using Stream = grpc::ClientReaderWriter<Request, Response>;

  // Holds the answer of `take` to a message: what to acknowledge and, in `over`, the result of run() if it is to end.
  struct Taken {
    std::int64_t sequence = 0;  // Number to acknowledge; 0: none.
    std::optional<grpc::Status> over = {};
  };

  // Runs the stream: `open(context)` begins a call, `start()` returns its first message, `take(response)` gets each
  // answer except the last. `connect(timeout)` looks for a lost server and returns true once it is there. Returns OK if
  // the stream was stopped or the server ended it.
  template <typename Open, typename Start, typename Take, typename Connect>
  grpc::Status run(const Open& open, const Start& start, const Take& take, const Connect& connect,
                   const Reopening& reopening) {
    auto lost_at = std::chrono::steady_clock::now();
    for (;;) {
      const auto opened_at = std::chrono::steady_clock::now();
      ended_ = {};
      has_answers_ = false;
      const grpc::Status status = run_once(open, start, take);
      const auto now = std::chrono::steady_clock::now();
      // Counts the server as back after a while even without messages, because a paused stream has none.
      if (has_answers_ || now - opened_at > kIsBackAfter) lost_at = now;
      const bool again = is_lost(status) ? now - lost_at < reopening.when_lost && wait_to_retry(connect)
                                         : reopening.when_slow && status.ok() && ended_.reason() == v1::Ended::TOO_SLOW;
      if (!again || stopped_) return stopped_ ? grpc::Status::OK : status;
    }
  }

  // Sends a setting, from any thread. Settings made before run() are sent after its first message, the newest of each
  // kind.
  void set(const Request& request) {
    const std::lock_guard lock(mutex_);
    settings_[request.kind_case()] = request;
    if (stream_ != nullptr) stream_->Write(request);
  }

  // Ends run(); callable from any thread.
  void stop() {
    const std::lock_guard lock(context_mutex_);
    stopped_ = true;
    if (context_ != nullptr) context_->TryCancel();
    stopping_.notify_all();
  }

  [[nodiscard]] const v1::Ended& ended() const { return ended_; }

  static Request acknowledgement(std::int64_t sequence, std::chrono::steady_clock::time_point arrived) {
    const auto held = std::chrono::steady_clock::now() - arrived;
    Request request;
    request.mutable_ack()->set_sequence(sequence);
    request.mutable_ack()->set_held_us(1 + std::chrono::duration_cast<std::chrono::microseconds>(held).count());
    return request;
  }

 private:
  template <typename Open, typename Start, typename Take>
  grpc::Status run_once(const Open& open, const Start& start, const Take& take) {
    grpc::ClientContext context;
    const Entered entered(*this, context);
    if (!entered) return grpc::Status::OK;
    const std::unique_ptr<Stream> stream = open(&context);
    const Writable writable(*this, *stream, start());
    Response response;
    std::optional<grpc::Status> over;
    while (!over && stream->Read(&response)) {
      const auto arrived = std::chrono::steady_clock::now();
      if (response.has_ended()) {
        ended_ = response.ended();
        continue;
      }
      has_answers_ = true;
      const Taken taken = take(response);
      over = taken.over;
      if (taken.sequence > 0) acknowledge(taken.sequence, arrived);
    }
    if (over) context.TryCancel();
    end(*stream);
    const grpc::Status status = stream->Finish();
    if (over) return *over;
    if (stopped_) return grpc::Status::OK;
    if (status.error_code() != grpc::StatusCode::CANCELLED) return status;
    // Supplies a reason, because a server cannot send one on a stream that is not read.
    ended_.set_reason(v1::Ended::TOO_SLOW);
    ended_.set_message("the server ended the stream: it was not read in time");
    return grpc::Status::OK;
  }

  // True if the server stopped, or if the error has no reason and so comes from gRPC itself.
  [[nodiscard]] bool is_lost(const grpc::Status& status) const {
    if (status.ok()) return ended_.reason() == v1::Ended::SERVER_STOPPING;
    return status.error_code() == grpc::StatusCode::UNAVAILABLE && failure_of(status).reason.empty();
  }

  // Waits before a retry, and looks for the server meanwhile; returns false if stopped.
  template <typename Connect>
  bool wait_to_retry(const Connect& connect) {
    const auto until = std::chrono::steady_clock::now() + kRetryAfter;
    while (!stopped_ && std::chrono::steady_clock::now() < until && !connect(kLooksFor)) {
    }
    std::unique_lock lock(context_mutex_);
    return !stopping_.wait_until(lock, until, [this] { return stopped_.load(); });
  }

  // Lets stop() cancel the call while the Entered exists, also if `take` throws. Converts to false if stop() was called
  // before, so that no call may begin.
  class Entered {
   public:
    Entered(LiveStream& live, grpc::ClientContext& context) : live_(live) {
      const std::lock_guard lock(live_.context_mutex_);
      if (!live_.stopped_) live_.context_ = &context;
      is_in_ = !live_.stopped_;
    }
    ~Entered() {
      const std::lock_guard lock(live_.context_mutex_);
      live_.context_ = nullptr;
    }
    Entered(const Entered&) = delete;
    Entered& operator=(const Entered&) = delete;
    explicit operator bool() const { return is_in_; }

   private:
    LiveStream& live_;
    bool is_in_ = false;
  };

  // Lets set() write to the stream while the Writable exists, until end().
  class Writable {
   public:
    Writable(LiveStream& live, Stream& stream, const Request& start) : live_(live) {
      const std::lock_guard lock(live_.mutex_);
      stream.Write(start);
      for (const auto& [kind, request] : live_.settings_) stream.Write(request);
      live_.stream_ = &stream;
    }
    ~Writable() {
      const std::lock_guard lock(live_.mutex_);
      live_.stream_ = nullptr;
    }
    Writable(const Writable&) = delete;
    Writable& operator=(const Writable&) = delete;

   private:
    LiveStream& live_;
  };

  void acknowledge(std::int64_t sequence, std::chrono::steady_clock::time_point arrived) {
    const std::lock_guard lock(mutex_);
    stream_->Write(acknowledgement(sequence, arrived));
  }
  void end(Stream& stream) {
    const std::lock_guard lock(mutex_);
    stream_ = nullptr;
    stream.WritesDone();
  }

  static constexpr std::chrono::milliseconds kRetryAfter{250};
  static constexpr std::chrono::milliseconds kLooksFor{50};
  static constexpr std::chrono::seconds kIsBackAfter{30};  // Longer than gRPC tries to connect.

  v1::Ended ended_;
  bool has_answers_ = false;  // True if the call in progress got an answer.
  std::atomic<bool> stopped_{false};
  std::mutex context_mutex_;  // Not held over a write, so that stop() never waits for one.
  std::condition_variable stopping_;
  grpc::ClientContext* context_ = nullptr;  // Context of the call in progress; guarded by context_mutex_.
  std::mutex mutex_;
  Stream* stream_ = nullptr;         // Stream of the call in progress, while it is writable; guarded by mutex_.
  std::map<int, Request> settings_;  // By kind; guarded by mutex_.
};

}  // namespace kerf::client
