#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace kerf::stream {

// Immutable bytes shared by several streams.
using Bytes = std::shared_ptr<const std::string>;

// Holds one serialised WatchResponse in parts, to be written in order without gaps. The few bytes of this stream alone
// come first, then those shared with others. A transport writes the parts without copying them (gRPC slices, a buffer
// sequence).
struct Message {
  std::vector<Bytes> parts;    // none null
  bool says_too_slow = false;  // True for Ended TOO_SLOW, the stream's last message.

  [[nodiscard]] std::size_t size() const {
    std::size_t total = 0;
    for (const Bytes& part : parts) total += part->size();
    return total;
  }
  [[nodiscard]] std::string joined() const {
    std::string all;
    all.reserve(size());
    for (const Bytes& part : parts) all += *part;
    return all;
  }
};

}  // namespace kerf::stream
