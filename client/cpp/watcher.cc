#include "client/cpp/watcher.h"

#include <optional>

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
  return request;
}

v1::WatchRequest acknowledgement(std::int64_t sequence, std::chrono::steady_clock::time_point arrived) {
  return FrameStream::acknowledgement(sequence, arrived);
}

grpc::Status Watcher::run(const std::string& name, const WatchOptions& options, const OnFrame& on_frame) {
  Mirror mirror;
  return stream_.run([this](grpc::ClientContext* context) { return client_.stream().Watch(context); },
                     start_of_watch(name, options),
                     [&](const v1::WatchResponse& response) -> FrameStream::Taken {
                       if (!response.has_frame()) return {};
                       const v1::Frame& frame = response.frame();
                       if (const std::optional<std::string> wrong = mirror.apply(frame)) {
                         return {0, grpc::Status(grpc::StatusCode::DATA_LOSS, "a frame does not fit: " + *wrong)};
                       }
                       if (on_frame(frame, mirror)) return {frame.sequence(), {}};
                       return {frame.sequence(), grpc::Status::OK};
                     });
}

void Watcher::set_pace(double max_rate_hz, bool paused) {
  v1::WatchRequest request;
  request.mutable_pace()->set_max_rate_hz(max_rate_hz);
  request.mutable_pace()->set_paused(paused);
  stream_.send(request);
}

}  // namespace kerf::client
