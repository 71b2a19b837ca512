#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>
#include <grpcpp/support/sync_stream.h>

#include "kerf/v1/stream.pb.h"

namespace kerf::client {

// What the streams have in common whose messages are acknowledged: Watch, WatchImages. One run.
template <typename Request, typename Response>
class LiveStream {
 public:
  using Stream = grpc::ClientReaderWriter<Request, Response>;

  // What became of one message: it is acknowledged, and the stream goes on or ends as `over` says.
  struct Taken {
    std::int64_t sequence = 0;  // 0: nothing to acknowledge
    std::optional<grpc::Status> over = {};
  };

  // `open(context)` begins the call, `take(response)` gets each message but the last. OK where the stream was stopped
  // or the server ended it.
  template <typename Open, typename Take>
  grpc::Status run(const Open& open, const Request& start, const Take& take) {
    const std::unique_ptr<Stream> stream = open(&context_);
    begin(*stream, start);
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
      if (taken.sequence > 0) send(acknowledgement(taken.sequence, arrived));
    }
    end(*stream, over.has_value());
    const grpc::Status status = stream->Finish();
    if (over) return *over;
    return stopped_ ? grpc::Status::OK : status;
  }

  // From any thread; what is sent before run() goes behind its start, what is sent after it nowhere.
  void send(const Request& request) {
    const std::lock_guard lock(mutex_);
    if (stream_ != nullptr) {
      stream_->Write(request);
    } else if (!over_) {
      waiting_.push_back(request);
    }
  }

  // From any thread: ends run().
  void stop() {
    stopped_ = true;
    context_.TryCancel();
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
  void begin(Stream& stream, const Request& start) {
    const std::lock_guard lock(mutex_);
    stream.Write(start);
    for (const Request& request : waiting_) stream.Write(request);
    waiting_.clear();
    stream_ = &stream;
  }
  void end(Stream& stream, bool cancel) {
    const std::lock_guard lock(mutex_);
    stream_ = nullptr;
    over_ = true;
    if (cancel) {
      context_.TryCancel();
    } else {
      stream.WritesDone();
    }
  }

  grpc::ClientContext context_;
  std::atomic<bool> stopped_{false};
  v1::Ended ended_;
  std::mutex mutex_;
  Stream* stream_ = nullptr;      // of run(), while it may be written to; guarded by mutex_
  bool over_ = false;             // run() has ended; guarded by mutex_
  std::vector<Request> waiting_;  // for run(); guarded by mutex_
};

}  // namespace kerf::client
