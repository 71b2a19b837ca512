#pragma once

#include <functional>

namespace kerf::fem {

// Stop condition polled by long computations, on their own thread; false ends them early. Once false it must stay false
// until the computation has returned.
using GoesOn = std::function<bool()>;

// Holds the stop condition polled by a long computation; none by default.
class Heed {
 public:
  // Sets the condition, which must outlive the computation. Null removes it.
  void set(const GoesOn* goes_on) { goes_on_ = goes_on; }
  [[nodiscard]] bool ends() const { return goes_on_ != nullptr && !(*goes_on_)(); }
  [[nodiscard]] const GoesOn* get() const { return goes_on_; }

 private:
  const GoesOn* goes_on_ = nullptr;
};

}  // namespace kerf::fem
