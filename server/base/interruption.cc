#include "server/base/interruption.h"

#include <utility>

namespace kerf {
namespace {

thread_local constinit InterruptionScope* innermost = nullptr;

}  // namespace

thread_local constinit int points_to_poll = kPointsToAPoll;

InterruptionScope::InterruptionScope(StopCondition stop) : stop_(std::move(stop)), outer_(innermost) {
  innermost = this;
  points_to_poll = 0;
}

InterruptionScope::~InterruptionScope() {
  innermost = outer_;
}

void poll_stop_condition() {
  points_to_poll = kPointsToAPoll;
  if (innermost != nullptr && innermost->stop_()) {
    points_to_poll = 0;  // if the exception is swallowed by mistake, the next point throws again
    throw Interrupted();
  }
}

}  // namespace kerf
