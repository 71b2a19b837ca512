#pragma once

#include <cstdint>
#include <mutex>

#include "server/base/result.h"

namespace kerf::host {

// Counts the vertices of all sheets of a host against a limit. Their memory is in proportion, see
// tests/bench/README.md, "Footprint". Thread-safe.
class VertexBudget {
 public:
  // `limit`: >= 1; 0: none.
  explicit VertexBudget(std::int64_t limit) : limit_(limit) {}

  // Adds `more`, >= 0, if the limit allows. kResourceExhausted TOO_MANY_VERTICES_IN_ALL.
  Status take(std::int64_t more);
  // Adds `by` even beyond the limit.
  void change(std::int64_t by);

 private:
  const std::int64_t limit_;
  std::mutex mutex_;
  std::int64_t in_use_ = 0;  // guarded by mutex_
};

// Holds one sheet's share of the budget, from before it is built until it is gone. Used by one thread at a time.
class VertexShare {
 public:
  // `taken`: already counted in the budget.
  VertexShare(VertexBudget& budget, std::int64_t taken) : budget_(budget), count_(taken) {}
  ~VertexShare() { set(0); }
  VertexShare(const VertexShare&) = delete;
  VertexShare& operator=(const VertexShare&) = delete;

  // Sets the count of a sheet just built, which may exceed the number declared before. Errors of take().
  Status settle(std::int64_t count);
  // Sets the present count. Never refused: a cut adds few vertices, and matters more than the last of the memory.
  void set(std::int64_t count);

 private:
  VertexBudget& budget_;
  std::int64_t count_;
};

}  // namespace kerf::host
