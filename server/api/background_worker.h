#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace kerf::api {

// One thread for work that takes long (drawing, encoding files) and must hold up neither a sheet nor a transport.
// Thread-safe.
class BackgroundWorker {
 public:
  // `max_waiting`: work that may wait behind what is being done.
  explicit BackgroundWorker(std::size_t max_waiting);
  ~BackgroundWorker();  // stop()
  BackgroundWorker(const BackgroundWorker&) = delete;
  BackgroundWorker& operator=(const BackgroundWorker&) = delete;

  enum class Outcome { kTaken, kFull, kStopped };
  // Takes `work` only if there is room. `refuse` is called in its place if it is stopped before its turn.
  Outcome submit(std::function<void()> work, std::function<void()> refuse);

  // Refuses what waits and what comes after, at once; what is being done goes on. Idempotent.
  void close();
  // close(), and waits for what is being done. Idempotent; not from within the work.
  void stop();

 private:
  struct Task {
    std::function<void()> work;
    std::function<void()> refuse;
  };

  void run();

  const std::size_t max_waiting_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> waiting_;
  bool busy_ = false;
  bool stopped_ = false;
  std::thread thread_;
};

}  // namespace kerf::api
