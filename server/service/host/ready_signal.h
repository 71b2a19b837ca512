#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace kerf::api {

// A callback that may be taken away while other threads call it. Thread-safe.
class ReadySignal {
 public:
  // Replaces the callback. When this returns, no call of the former one is under way, except one that this call comes
  // from within.
  void set(std::function<void()> ready);

  // Calls it, if there is one, with no lock held.
  void raise();

 private:
  std::mutex mutex_;
  std::condition_variable returned_;
  std::shared_ptr<const std::function<void()>> ready_;
  std::vector<std::thread::id> callers_;  // of calls under way, of this callback or a former one
};

}  // namespace kerf::api
