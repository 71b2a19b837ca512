#include "server/service/host/wake_timer.h"

namespace kerf::host {

void WakeTimer::wake_at(Nanoseconds deadline, std::function<void()> fire) {
  const std::lock_guard lock(mutex_);
  if (stopped_ || (timer_ && timer_->first <= deadline)) return;
  if (timer_) clock_.cancel(timer_->second);
  timer_ = {deadline, clock_.schedule(deadline, std::move(fire))};
}

void WakeTimer::fired() {
  const std::lock_guard lock(mutex_);
  timer_.reset();
}

void WakeTimer::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  if (timer_) clock_.cancel(timer_->second);
  timer_.reset();
}

}  // namespace kerf::host
