#include "client/load/ramp.h"

#include <utility>

namespace kerf::load {

Ramp::Ramp(const std::vector<Stage>& stages, Nanoseconds begin, Waiter& waiter, std::function<void(std::int32_t)> set)
    : thread_([steps = steps_of(stages), begin, &waiter, set = std::move(set)] {
        for (const Step& step : steps) {
          if (!waiter.wait_until(begin + step.time)) return;
          set(step.count);
        }
      }) {}

Ramp::~Ramp() {
  thread_.join();
}

}  // namespace kerf::load
