#include "server/service/rpc/transfer_deadline.h"

#include <algorithm>
#include <utility>

namespace kerf::rpc {

void TransferDeadline::begin(std::function<void(Timeout)> on_timeout) {
  host::Nanoseconds deadline{0};
  {
    const std::lock_guard lock(mutex_);
    on_timeout_ = std::move(on_timeout);
    total_deadline_ = clock_.now() + timeouts_.total;
    extend();
    deadline = deadline_;
  }
  wait_until(deadline);
}

// Moves the deadline but not the timer: when the timer fires early, it is set for the remaining time.
bool TransferDeadline::made_progress() {
  const std::lock_guard lock(mutex_);
  extend();
  return on_timeout_ != nullptr;
}

void TransferDeadline::extend() {
  deadline_ = std::min(clock_.now() + timeouts_.idle, total_deadline_);
}

bool TransferDeadline::end() {
  std::function<void(Timeout)> on_timeout;
  {
    const std::lock_guard lock(mutex_);
    on_timeout_.swap(on_timeout);
  }
  timer_.stop();
  return on_timeout != nullptr;
}

void TransferDeadline::wait_until(host::Nanoseconds deadline) {
  timer_.wake_at(deadline, [weak = weak_from_this()] {
    if (const auto alive = weak.lock()) alive->timer_fired();
  });
}

void TransferDeadline::timer_fired() {
  timer_.fired();
  std::function<void(Timeout)> on_timeout;
  host::Nanoseconds deadline{0};
  Timeout timeout = Timeout::kIdle;
  {
    const std::lock_guard lock(mutex_);
    if (!on_timeout_) return;
    deadline = deadline_;
    if (deadline == total_deadline_) timeout = Timeout::kTotal;
    if (clock_.now() >= deadline) on_timeout_.swap(on_timeout);
  }
  if (on_timeout) {
    on_timeout(timeout);
  } else {
    wait_until(deadline);
  }
}

}  // namespace kerf::rpc
