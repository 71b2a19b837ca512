#pragma once

#include <mutex>

#include "server/host/metrics.h"

namespace kerf::host {

// The counters of one host, written by all its strands.
class MetricsBoard {
 public:
  template <typename Change>
  void update(Change change) {
    const std::lock_guard lock(mutex_);
    change(metrics_);
  }
  [[nodiscard]] HostMetrics read() const {
    const std::lock_guard lock(mutex_);
    return metrics_;
  }

 private:
  mutable std::mutex mutex_;
  HostMetrics metrics_;
};

}  // namespace kerf::host
