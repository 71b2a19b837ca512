#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace kerf::host {

// Holds a callback that may be removed while other threads call it. Thread-safe.
class WakeCallback {
 public:
  // Replaces the callback. When this returns, no call of the former callback is in progress, except one that itself
  // called set().
  void set(std::function<void()> wake);

  // Calls the callback, if set, with no lock held.
  void call();

 private:
  std::mutex mutex_;
  std::condition_variable returned_;
  std::shared_ptr<const std::function<void()>> wake_;
  std::vector<std::thread::id> callers_;  // Threads of calls in progress, to this callback or a former one.
};

}  // namespace kerf::host
