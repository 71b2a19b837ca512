#pragma once

#include <cstdint>
#include <mutex>

#include "server/base/result.h"

namespace kerf::host {

// How many vertices all sheets of a host have together, and how many they may: their memory is in proportion, see
// tests/bench/README.md, "Footprint". Thread-safe.
class VertexBudget {
 public:
  // `limit`: >= 1; 0: none.
  explicit VertexBudget(std::int64_t limit) : limit_(limit) {}

  // Counts `more`, >= 0, where the limit leaves room for them. kResourceExhausted TOO_MANY_VERTICES_IN_ALL.
  Status take(std::int64_t more);
  // Counts a change, whatever the limit says.
  void change(std::int64_t by);

 private:
  const std::int64_t limit_;
  std::mutex mutex_;
  std::int64_t in_use_ = 0;  // guarded by mutex_
};

// What one sheet has of it, from before it is built until it is gone. Used by one thread at a time.
class VertexShare {
 public:
  // `taken`: counted already.
  VertexShare(VertexBudget& budget, std::int64_t taken) : budget_(budget), count_(taken) {}
  ~VertexShare() { set(0); }
  VertexShare(const VertexShare&) = delete;
  VertexShare& operator=(const VertexShare&) = delete;

  // The sheet is built and has that many, which may be more than could be told before: take()'s error.
  Status settle(std::int64_t count);
  // It has that many now. Never refused: a cut adds few, and is worth more to who makes it than the last of the memory.
  void set(std::int64_t count);

 private:
  VertexBudget& budget_;
  std::int64_t count_;
};

}  // namespace kerf::host
