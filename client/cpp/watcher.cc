#include "client/cpp/watcher.h"

#include <chrono>
#include <optional>

namespace kerf::client {

v1::WatchRequest start_of_watch(const std::string& name, const WatchOptions& options) {
  v1::WatchRequest request;
  v1::WatchStart& start = *request.mutable_start();
  start.set_name(name);
  start.set_window(options.window);
  start.set_max_rate_hz(options.max_rate_hz);
  start.set_encoding(options.encoding);
  return request;
}

v1::WatchRequest acknowledgement(std::int64_t sequence, std::chrono::steady_clock::time_point arrived) {
  const auto held = std::chrono::steady_clock::now() - arrived;
  v1::WatchRequest request;
  request.mutable_ack()->set_sequence(sequence);
  request.mutable_ack()->set_held_us(1 + std::chrono::duration_cast<std::chrono::microseconds>(held).count());
  return request;
}

grpc::Status Watcher::run(const std::string& name, const WatchOptions& options, const OnFrame& on_frame) {
  const auto stream = client_.stream().Watch(&context_);
  stream->Write(start_of_watch(name, options));

  Mirror mirror;
  v1::WatchResponse response;
  grpc::Status failure = grpc::Status::OK;
  bool wanted = true;
  while (wanted && stream->Read(&response)) {
    const auto arrived = std::chrono::steady_clock::now();
    if (response.has_ended()) ended_ = response.ended();
    if (!response.has_frame()) continue;
    if (const std::optional<std::string> wrong = mirror.apply(response.frame())) {
      failure = grpc::Status(grpc::StatusCode::DATA_LOSS, "a frame does not fit: " + *wrong);
      break;
    }
    wanted = on_frame(response.frame(), mirror);
    stream->Write(acknowledgement(response.frame().sequence(), arrived));
  }
  if (!wanted || !failure.ok()) {
    context_.TryCancel();
    stream->Finish();
    return failure;
  }
  stream->WritesDone();
  const grpc::Status status = stream->Finish();
  return stopped_ ? grpc::Status::OK : status;
}

void Watcher::stop() {
  stopped_ = true;
  context_.TryCancel();
}

}  // namespace kerf::client
