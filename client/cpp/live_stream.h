#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include "kerf/v1/stream.pb.h"

namespace kerf::client {

// What the streams have in common whose messages are acknowledged: Watch, WatchImages. For one run().
template <typename Request, typename Response>
class LiveStream {
 public:
  using Stream = grpc::ClientReaderWriter<Request, Response>;

  // What became of one message: it is acknowledged, and the stream goes on or ends as `over` says.
  struct Taken {
    std::int64_t sequence = 0;  // 0: nothing to acknowledge
    std::optional<grpc::Status> over = {};
  };

  // `open(context)` begins a call, `start()` gives its first message, `take(response)` gets each answer but the last.
  // OK where the stream was stopped or the server ended it. reopens: one that the server ended as TOO_SLOW is opened
  // again, and what was set is set again.
  template <typename Open, typename Start, typename Take>
  grpc::Status run(const Open& open, const Start& start, const Take& take, bool reopens) {
    for (;;) {
      ended_ = {};
      const grpc::Status status = run_once(open, start, take);
      if (!reopens || !status.ok() || stopped_ || ended_.reason() != v1::Ended::TOO_SLOW) return status;
    }
  }

  // From any thread. What is set before run() goes behind its start; of each kind the newest counts.
  void set(const Request& request) {
    const std::lock_guard lock(mutex_);
    settings_[request.kind_case()] = request;
    if (stream_ != nullptr) stream_->Write(request);
  }

  // From any thread: ends run().
  void stop() {
    const std::lock_guard lock(context_mutex_);
    stopped_ = true;
    if (context_ != nullptr) context_->TryCancel();
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
      const Taken taken = take(response);
      over = taken.over;
      if (taken.sequence > 0) acknowledge(taken.sequence, arrived);
    }
    if (over) context.TryCancel();
    end(*stream);
    const grpc::Status status = stream->Finish();
    if (over) return *over;
    return stopped_ ? grpc::Status::OK : status;
  }

  // While it lives, stop() cancels the call; also where `take` throws. False: run() was stopped, and begins nothing.
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

  // While it lives, set() writes to the stream, until end().
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

  v1::Ended ended_;
  std::atomic<bool> stopped_{false};
  std::mutex context_mutex_;                // not held over a write, so that stop() is not held up by one
  grpc::ClientContext* context_ = nullptr;  // of the call under way; guarded by context_mutex_
  std::mutex mutex_;
  Stream* stream_ = nullptr;         // of the call under way, while it may be written to; guarded by mutex_
  std::map<int, Request> settings_;  // by kind; guarded by mutex_
};

}  // namespace kerf::client
