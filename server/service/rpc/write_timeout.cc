#include "server/service/rpc/write_timeout.h"

#include <utility>

namespace kerf::rpc {

// Notes the start of each write. A pending timer stays as it is: when it fires early, it is set for the remaining time.
void WriteTimeout::write_begun() {
  const host::Nanoseconds now = clock_.now();
  {
    const std::lock_guard lock(mutex_);
    begun_at_ = now;
    if (std::exchange(is_timed_, true)) return;
  }
  wait_until(now + timeout_);
}

void WriteTimeout::write_done() {
  const std::lock_guard lock(mutex_);
  begun_at_.reset();
}

void WriteTimeout::stop() {
  on_timeout_.set({});
  timer_.stop();
}

void WriteTimeout::wait_until(host::Nanoseconds deadline) {
  timer_.wake_at(deadline, [weak = weak_from_this()] {
    if (const auto alive = weak.lock()) alive->timer_fired();
  });
}

void WriteTimeout::timer_fired() {
  timer_.fired();
  host::Nanoseconds deadline{};
  bool is_stuck = false;
  {
    const std::lock_guard lock(mutex_);
    if (begun_at_) deadline = *begun_at_ + timeout_;
    is_stuck = begun_at_ && clock_.now() >= deadline;
    is_timed_ = begun_at_ && !is_stuck;
    if (!is_timed_ && !is_stuck) return;
  }
  if (is_stuck) return on_timeout_.call();
  wait_until(deadline);
}

}  // namespace kerf::rpc
