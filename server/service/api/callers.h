#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <mutex>
#include <stop_token>

namespace kerf::api {

// Tracks the callers that wait for one piece of work, which must stop once all have left. Thread-safe.
class Callers {
 public:
  Callers() = default;
  Callers(const Callers&) = delete;
  Callers& operator=(const Callers&) = delete;

  // Adds a caller, whose token is triggered when it leaves. A token that cannot be triggered keeps the work going.
  void join(const std::stop_token& caller);
  // Returns a token that is triggered when the last caller has left.
  [[nodiscard]] std::stop_token all_left() const { return all_left_.get_token(); }

 private:
  using Leaving = std::stop_callback<std::function<void()>>;

  void leave();

  std::atomic<int> num_present_ = 0;
  std::stop_source all_left_;
  std::mutex mutex_;
  std::list<Leaving> leavings_;  // guarded by mutex_
};

}  // namespace kerf::api
