#include "tests/support/manual_clock.h"

#include "server/base/check.h"

namespace kerf::test {

host::Nanoseconds ManualClock::now() const {
  const std::lock_guard lock(mutex_);
  return now_;
}

std::int64_t ManualClock::unix_us() const {
  return std::chrono::duration_cast<std::chrono::microseconds>(now()).count();
}

host::Nanoseconds ManualClock::thread_cpu() const {
  return now();
}

host::TimerId ManualClock::schedule(host::Nanoseconds deadline, std::function<void()> fire) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t id = next_timer_++;
  timers_.emplace(Key{deadline, id}, std::move(fire));
  return host::TimerId{id};
}

bool ManualClock::cancel(host::TimerId timer) {
  const std::lock_guard lock(mutex_);
  for (auto entry = timers_.begin(); entry != timers_.end(); ++entry) {
    if (entry->first.second != static_cast<std::uint64_t>(timer)) continue;
    timers_.erase(entry);
    return true;
  }
  return false;
}

std::optional<host::Nanoseconds> ManualClock::next_deadline() const {
  const std::lock_guard lock(mutex_);
  if (timers_.empty()) return std::nullopt;
  return timers_.begin()->first.first;
}

std::size_t ManualClock::num_timers() const {
  const std::lock_guard lock(mutex_);
  return timers_.size();
}

void ManualClock::move_to(host::Nanoseconds time) {
  {
    const std::lock_guard lock(mutex_);
    KERF_CHECK(time >= now_, "time runs forward");
    now_ = time;
  }
  while (true) {
    std::function<void()> fire;
    {
      const std::lock_guard lock(mutex_);
      if (timers_.empty() || timers_.begin()->first.first > now_) return;
      fire = std::move(timers_.begin()->second);
      timers_.erase(timers_.begin());
    }
    fire();
  }
}

}  // namespace kerf::test
