#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <mutex>
#include <stop_token>

namespace kerf::api {

// Those who wait for one piece of work, which is to stop once all of them have left. Thread-safe.
class Callers {
 public:
  Callers() = default;
  Callers(const Callers&) = delete;
  Callers& operator=(const Callers&) = delete;

  // `caller`: requests a stop where this caller leaves; one that cannot stays for good.
  void join(const std::stop_token& caller);
  // Requests a stop when the last of those who joined has left.
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
