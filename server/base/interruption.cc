#include "server/base/interruption.h"

#include <utility>

namespace kerf {
namespace {

thread_local constinit InterruptionScope* innermost = nullptr;

}  // namespace

thread_local constinit int points_to_asking = kPointsToAnAsking;

InterruptionScope::InterruptionScope(std::function<bool()> goes_on) : goes_on_(std::move(goes_on)), outer_(innermost) {
  innermost = this;
  points_to_asking = 0;
}

InterruptionScope::~InterruptionScope() {
  innermost = outer_;
}

void ask_whether_to_go_on() {
  points_to_asking = kPointsToAnAsking;
  if (innermost != nullptr && !innermost->goes_on_()) {
    points_to_asking = 0;  // what catches it by mistake is asked at once
    throw Interrupted();
  }
}

}  // namespace kerf
