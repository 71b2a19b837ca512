#include "server/rpc/patience.h"

#include <utility>

namespace kerf::rpc {

void Patience::begin(std::function<void()> give_up) {
  const host::Nanoseconds deadline = clock_.now() + limit_;
  {
    const std::lock_guard lock(mutex_);
    give_up_ = std::move(give_up);
    deadline_ = deadline;
  }
  wait_until(deadline);
}

// The timer stays where it is: when it fires, it is set anew for what is left.
bool Patience::arrived() {
  const std::lock_guard lock(mutex_);
  deadline_ = clock_.now() + limit_;
  return give_up_ != nullptr;
}

bool Patience::end() {
  std::function<void()> give_up;
  {
    const std::lock_guard lock(mutex_);
    give_up_.swap(give_up);
  }
  timer_.stop();
  return give_up != nullptr;
}

void Patience::wait_until(host::Nanoseconds deadline) {
  timer_.wake_at(deadline, [weak = weak_from_this()] {
    if (const auto alive = weak.lock()) alive->timer_fired();
  });
}

void Patience::timer_fired() {
  timer_.fired();
  std::function<void()> give_up;
  host::Nanoseconds deadline{0};
  {
    const std::lock_guard lock(mutex_);
    if (!give_up_) return;
    deadline = deadline_;
    if (clock_.now() >= deadline) give_up_.swap(give_up);
  }
  if (give_up) {
    give_up();
  } else {
    wait_until(deadline);
  }
}

}  // namespace kerf::rpc
