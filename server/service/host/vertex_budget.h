#pragma once

#include <cstdint>
#include <mutex>

#include "server/base/result.h"

namespace kerf::host {

// Counts the vertices of all sheets of a host against a limit. A sheet's memory grows in proportion to its vertices,
// see tests/bench/README.md, "Footprint". Thread-safe.
class VertexBudget {
 public:
  // `limit`: >= 1; 0: none.
  explicit VertexBudget(std::int64_t limit) : limit_(limit) {}

  // Adds `more` vertices, >= 0, or returns kResourceExhausted TOO_MANY_VERTICES_IN_ALL if that would exceed the limit.
  Status take(std::int64_t more);
  // Adds `by` vertices, or removes them if negative, even beyond the limit.
  void change(std::int64_t by);

 private:
  const std::int64_t limit_;
  std::mutex mutex_;
  std::int64_t in_use_ = 0;  // guarded by mutex_
};

}  // namespace kerf::host
