#pragma once

#include <atomic>
#include <cstdint>

#include "server/service/host/clock.h"

namespace kerf::host {

// Sums up the CPU time of ticks that a restart would have to repeat, of all sheets of a host. Thread-safe.
class UnsavedWork {
 public:
  [[nodiscard]] Nanoseconds total() const { return Nanoseconds(total_); }
  // Returns the mean of the sheets that have any; 0 if none has.
  [[nodiscard]] Nanoseconds mean() const {
    const std::int64_t sheets = sheets_;
    return sheets > 0 ? Nanoseconds(total_ / sheets) : Nanoseconds{0};
  }

 private:
  friend class UnsavedShare;
  std::atomic<std::int64_t> total_{0};   // ns
  std::atomic<std::int64_t> sheets_{0};  // Those with a share above 0.
};

// The share of one sheet, for one thread at a time. Ends with it.
class UnsavedShare {
 public:
  // `all` must outlive this.
  explicit UnsavedShare(UnsavedWork& all) : all_(all) {}
  ~UnsavedShare() { clear(); }
  UnsavedShare(const UnsavedShare&) = delete;
  UnsavedShare& operator=(const UnsavedShare&) = delete;

  // `cpu`: >= 0
  void add(Nanoseconds cpu) {
    if (own_.count() == 0 && cpu.count() > 0) ++all_.sheets_;
    own_ += cpu;
    all_.total_ += cpu.count();
  }
  void clear() {
    if (own_.count() > 0) --all_.sheets_;
    all_.total_ -= own_.count();
    own_ = Nanoseconds{0};
  }
  [[nodiscard]] Nanoseconds value() const { return own_; }

 private:
  UnsavedWork& all_;
  Nanoseconds own_{0};
};

}  // namespace kerf::host
