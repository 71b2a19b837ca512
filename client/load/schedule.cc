#include "client/load/schedule.h"

namespace kerf::load {

Nanoseconds now() {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::steady_clock::now().time_since_epoch());
}

std::int64_t microseconds(Nanoseconds time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time).count();
}

bool Stopper::wait_until(Nanoseconds time) {
  const std::chrono::steady_clock::time_point at(std::chrono::duration_cast<std::chrono::steady_clock::duration>(time));
  std::unique_lock lock(mutex_);
  return !changed_.wait_until(lock, at, [this] { return stopped_; });
}

void Stopper::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

bool Stopper::stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

std::int64_t run_schedule(const Schedule& schedule, Nanoseconds end, Waiter& waiter,
                          const std::function<void(std::int64_t k, Nanoseconds intended)>& arrive) {
  for (std::int64_t k = 0;; ++k) {
    const Nanoseconds intended = schedule.at(k);
    if (intended >= end || !waiter.wait_until(intended)) return k;
    arrive(k, intended);
  }
}

}  // namespace kerf::load
