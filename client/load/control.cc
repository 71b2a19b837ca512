#include "client/load/control.h"

namespace kerf::load {

Control::Control(const Schedule& schedule, Nanoseconds end, Waiter& waiter)
    : thread_([this, schedule, end, &waiter] {
        run_schedule(schedule, end, waiter, [&](std::int64_t /*k*/, Nanoseconds intended) {
          const std::int64_t late = microseconds(waiter.now() - intended);
          const std::lock_guard lock(mutex_);
          lateness_us_.add(late);
        });
      }) {}

Control::~Control() {
  thread_.join();
}

Histogram Control::lateness_us() const {
  const std::lock_guard lock(mutex_);
  return lateness_us_;
}

}  // namespace kerf::load
