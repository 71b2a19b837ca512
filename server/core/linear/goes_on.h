#pragma once

#include <functional>

namespace kerf::fem {

// Asked now and then by what takes long, on its own thread: false ends it early. Once false it must stay so until what
// it ended has returned.
using GoesOn = std::function<bool()>;

// Whom something long asks; nobody at first.
class Heed {
 public:
  // Null: nobody. To outlive what is done under it.
  void set(const GoesOn* goes_on) { goes_on_ = goes_on; }
  [[nodiscard]] bool ends() const { return goes_on_ != nullptr && !(*goes_on_)(); }
  [[nodiscard]] const GoesOn* get() const { return goes_on_; }

 private:
  const GoesOn* goes_on_ = nullptr;
};

}  // namespace kerf::fem
