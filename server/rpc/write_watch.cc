#include "server/rpc/write_watch.h"

namespace kerf::rpc {

// A timer that is set already stays where it is: when it fires, it is set anew for what is left.
void WriteWatch::begun() {
  const host::Nanoseconds now = clock_.now();
  {
    const std::lock_guard lock(mutex_);
    begun_at_ = now;
  }
  wait_until(now + limit_);
}

void WriteWatch::done() {
  const std::lock_guard lock(mutex_);
  begun_at_.reset();
}

void WriteWatch::stop() {
  stuck_.set({});
  timer_.stop();
}

void WriteWatch::wait_until(host::Nanoseconds deadline) {
  timer_.wake_at(deadline, [weak = weak_from_this()] {
    if (const auto alive = weak.lock()) alive->timer_fired();
  });
}

void WriteWatch::timer_fired() {
  timer_.fired();
  std::optional<host::Nanoseconds> begun_at;
  {
    const std::lock_guard lock(mutex_);
    begun_at = begun_at_;
  }
  if (!begun_at) return;
  if (clock_.now() < *begun_at + limit_) return wait_until(*begun_at + limit_);
  stuck_.raise();
}

}  // namespace kerf::rpc
