#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kerf::api {

// Threads for work that takes long (drawing, encoding files) and must hold up neither a sheet nor a transport. Work is
// begun in the order in which it came, and lets no exception out: see caught().
// Thread-safe.
class BackgroundWorker {
 public:
  // `max_waiting`: work that may wait behind what is being done, one piece on each thread.
  explicit BackgroundWorker(std::size_t max_waiting, std::size_t num_threads = 1);
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
  std::size_t idle_;  // threads
  bool stopped_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace kerf::api
