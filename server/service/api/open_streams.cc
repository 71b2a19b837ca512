#include "server/service/api/open_streams.h"

#include <vector>

namespace kerf::api {

void OpenStreams::add(const std::shared_ptr<OpenStream>& stream) {
  const std::lock_guard lock(mutex_);
  streams_[stream.get()] = stream;
}

void OpenStreams::remove(const OpenStream& stream) {
  const std::lock_guard lock(mutex_);
  streams_.erase(&stream);
}

void OpenStreams::notify_stop() {
  std::vector<std::shared_ptr<OpenStream>> open;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [address, weak] : streams_) {
      if (auto stream = weak.lock()) open.push_back(std::move(stream));
    }
  }
  for (const auto& stream : open) stream->server_stops();
}

}  // namespace kerf::api
