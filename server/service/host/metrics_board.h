#pragma once

#include <cstdint>
#include <mutex>

#include "server/service/host/metrics.h"

namespace kerf::host {

// Holds the counters of one host, written by all its strands.
class MetricsBoard {
 public:
  template <typename Change>
  void update(Change change) {
    const std::lock_guard lock(mutex_);
    change(metrics_);
  }
  // Reads the worker need alone: every new sheet asks for it, and a copy of all metrics is a kilobyte.
  [[nodiscard]] std::int64_t worker_need() const {
    const std::lock_guard lock(mutex_);
    return metrics_.worker_need;
  }
  [[nodiscard]] HostMetrics read() const {
    const std::lock_guard lock(mutex_);
    return metrics_;
  }

 private:
  mutable std::mutex mutex_;
  HostMetrics metrics_;
};

// Adds the expected need of a sheet being built to the board, as long as this lives.
class ExpectedNeed {
 public:
  ExpectedNeed(MetricsBoard& board, std::int64_t need) : board_(board), need_(need) { add(need_); }
  ~ExpectedNeed() { add(-need_); }
  ExpectedNeed(const ExpectedNeed&) = delete;
  ExpectedNeed& operator=(const ExpectedNeed&) = delete;

 private:
  void add(std::int64_t need) {
    board_.update([need](HostMetrics& m) { m.worker_need += need; });
  }

  MetricsBoard& board_;
  const std::int64_t need_;
};

}  // namespace kerf::host
