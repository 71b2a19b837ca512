#include "server/service/rpc/patience.h"

#include <algorithm>
#include <utility>

namespace kerf::rpc {

void Patience::begin(std::function<void(Lapse)> give_up) {
  host::Nanoseconds deadline{0};
  {
    const std::lock_guard lock(mutex_);
    give_up_ = std::move(give_up);
    end_ = clock_.now() + limits_.whole;
    wait_anew();
    deadline = deadline_;
  }
  wait_until(deadline);
}

// Leaves the timer as it is: when it fires, it is reset for the remaining time.
bool Patience::moved() {
  const std::lock_guard lock(mutex_);
  wait_anew();
  return give_up_ != nullptr;
}

void Patience::wait_anew() {
  deadline_ = std::min(clock_.now() + limits_.silence, end_);
}

bool Patience::end() {
  std::function<void(Lapse)> give_up;
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
  std::function<void(Lapse)> give_up;
  host::Nanoseconds deadline{0};
  Lapse lapse = Lapse::kSilence;
  {
    const std::lock_guard lock(mutex_);
    if (!give_up_) return;
    deadline = deadline_;
    if (deadline == end_) lapse = Lapse::kWhole;
    if (clock_.now() >= deadline) give_up_.swap(give_up);
  }
  if (give_up) {
    give_up(lapse);
  } else {
    wait_until(deadline);
  }
}

}  // namespace kerf::rpc
