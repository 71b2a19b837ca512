#include "server/service/api/open_streams.h"

namespace kerf::api {

void OpenStreams::add(const std::shared_ptr<OpenStream>& stream) {
  const std::lock_guard lock(mutex_);
  streams_[stream.get()] = stream;
}

void OpenStreams::remove(const OpenStream& stream) {
  const std::lock_guard lock(mutex_);
  streams_.erase(&stream);
}

std::vector<std::shared_ptr<OpenStream>> OpenStreams::open() {
  std::vector<std::shared_ptr<OpenStream>> found;
  const std::lock_guard lock(mutex_);
  for (const auto& [address, weak] : streams_) {
    if (auto stream = weak.lock()) found.push_back(std::move(stream));
  }
  return found;
}

void OpenStreams::notify_stop() {
  for (const auto& stream : open()) stream->server_stops();
}

void OpenStreams::check_callers() {
  for (const auto& stream : open()) stream->check_caller();
}

}  // namespace kerf::api
