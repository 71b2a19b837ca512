#pragma once

#include <atomic>
#include <cstdint>

#include "server/core/scene/sheet_config.h"

namespace kerf::host {

// Returns the memory that building or loading a sheet of `config` with `num_vertices` vertices may need at once, bytes.
inline std::int64_t bytes_to_build(const scene::SheetConfig& config, std::int64_t num_vertices) {
  // Bytes per vertex while a sheet is being built; up to 6,600 were measured, with a jittered grid of 700 x 700.
  constexpr std::int64_t kBytesPerVertex = 8000;
  return num_vertices * (kBytesPerVertex + (config.self_contact.is_on ? scene::kSelfContactBytes : 0));
}

// Reserves the memory that one builder may need, so that another one does not count on it too.
class PromisedBytes {
 public:
  PromisedBytes(std::atomic<std::int64_t>& sum, std::int64_t bytes)
      : sum_(sum), bytes_(bytes), in_all_(sum.fetch_add(bytes) + bytes) {}
  ~PromisedBytes() { sum_ -= bytes_; }
  PromisedBytes(const PromisedBytes&) = delete;
  PromisedBytes& operator=(const PromisedBytes&) = delete;

  // Returns the sum of this promise and those before it.
  [[nodiscard]] std::int64_t in_all() const { return in_all_; }

 private:
  std::atomic<std::int64_t>& sum_;
  const std::int64_t bytes_;
  const std::int64_t in_all_;
};

}  // namespace kerf::host
