#pragma once

#include <functional>

namespace kerf {

// A function that a long computation calls on its own thread; if it returns true, the computation ends early. Once true
// it must stay true until the computation has returned.
using StopCondition = std::function<bool()>;

// Holds the stop condition polled by a long computation; none by default.
class StopPoll {
 public:
  // Sets the condition, which must outlive the computation. Null removes it.
  void set(const StopCondition* stop) { stop_ = stop; }
  [[nodiscard]] bool is_met() const { return stop_ != nullptr && (*stop_)(); }
  [[nodiscard]] const StopCondition* get() const { return stop_; }

 private:
  const StopCondition* stop_ = nullptr;
};

}  // namespace kerf
