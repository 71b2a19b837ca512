#include "client/cpp/watcher.h"

namespace kerf::client {

using FrameStream = LiveStream<v1::WatchRequest, v1::WatchResponse>;

v1::WatchRequest start_of_watch(const std::string& name, const WatchOptions& options) {
  v1::WatchRequest request;
  v1::WatchStart& start = *request.mutable_start();
  start.set_name(name);
  start.set_window(options.window);
  start.set_max_rate_hz(options.max_rate_hz);
  start.set_encoding(options.encoding);
  start.set_strains(options.strains);
  start.mutable_probes()->Assign(options.probes.begin(), options.probes.end());
  return request;
}

v1::WatchRequest acknowledgement(std::int64_t sequence, std::chrono::steady_clock::time_point arrived) {
  return FrameStream::acknowledgement(sequence, arrived);
}

std::optional<grpc::Status> misfit(Mirror& mirror, const v1::Frame& frame) {
  const std::optional<std::string> wrong = mirror.apply(frame);
  if (!wrong) return std::nullopt;
  return grpc::Status(grpc::StatusCode::DATA_LOSS, "a frame does not fit: " + *wrong);
}

grpc::Status Watcher::run(const std::string& name, const WatchOptions& options, const OnFrame& on_frame) {
  Mirror mirror;
  const auto open = [this](grpc::ClientContext* context) { return client_.stream().Watch(context); };
  const auto start = [&] {
    mirror = Mirror();
    return start_of_watch(name, options);
  };
  const auto take = [&](const v1::WatchResponse& response) -> FrameStream::Taken {
    if (!response.has_frame()) return {};
    const v1::Frame& frame = response.frame();
    if (const std::optional<grpc::Status> wrong = misfit(mirror, frame)) return {0, wrong};
    if (on_frame(frame, mirror)) return {frame.sequence(), {}};
    return {frame.sequence(), grpc::Status::OK};
  };
  const auto connect = [this](std::chrono::milliseconds timeout) { return client_.wait_until_connected(timeout); };
  return stream_.run(open, start, take, connect, options.reopening);
}

void Watcher::set_pace(double max_rate_hz, bool paused) {
  v1::WatchRequest request;
  request.mutable_pace()->set_max_rate_hz(max_rate_hz);
  request.mutable_pace()->set_paused(paused);
  stream_.set(request);
}

}  // namespace kerf::client
