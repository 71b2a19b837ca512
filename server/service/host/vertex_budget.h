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

// Holds the vertices that one sheet takes of the budget, from before it is built until it is gone. Used by one thread
// at a time.
class VertexShare {
 public:
  // `taken`: vertices of the sheet that the budget has counted already.
  VertexShare(VertexBudget& budget, std::int64_t taken) : budget_(budget), count_(taken) {}
  ~VertexShare() { set(0); }
  VertexShare(const VertexShare&) = delete;
  VertexShare& operator=(const VertexShare&) = delete;

  // Sets the count of a sheet just built, which may exceed the number declared before. Errors of take().
  Status settle(std::int64_t count);
  // Sets the present count. Never refused: cuts add few vertices, and refusing a cut would be worse than exceeding the
  // limit.
  void set(std::int64_t count);

 private:
  VertexBudget& budget_;
  std::int64_t count_;
};

}  // namespace kerf::host
