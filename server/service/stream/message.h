#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace kerf::stream {

// Immutable bytes that several streams send.
using Bytes = std::shared_ptr<const std::string>;

// One serialised WatchResponse in parts, to be written in order without gaps: the few bytes of this stream's own, then
// what it shares with others. A transport passes the parts on as they are (gRPC slices, a buffer sequence).
struct Message {
  std::vector<Bytes> parts;    // none null
  bool says_too_slow = false;  // the stream's last, Ended TOO_SLOW

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
