#pragma once

#include <memory>
#include <mutex>

namespace kerf::host {

// Holds a value that one thread replaces while others read it. Readers keep the value that they got. Thread-safe.
template <typename T>
class SharedSlot {
 public:
  void set(T value) {
    auto shared = std::make_shared<const T>(std::move(value));
    const std::lock_guard lock(mutex_);
    value_.swap(shared);
  }
  // Returns null before the first set().
  [[nodiscard]] std::shared_ptr<const T> get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const T> value_;  // guarded by mutex_
};

}  // namespace kerf::host
