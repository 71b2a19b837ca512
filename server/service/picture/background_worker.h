#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kerf::picture {

// Runs long work (drawing, encoding files) on its own threads, so that neither sheets nor transports wait. Work begins
// in the order of its arrival and must not throw: see catch_exceptions(). Thread-safe.
class BackgroundWorker {
 public:
  // `max_waiting`: limit on pieces of work that wait while every thread is busy with another one.
  explicit BackgroundWorker(std::size_t max_waiting, std::size_t num_threads = 1);
  ~BackgroundWorker();  // stop()
  BackgroundWorker(const BackgroundWorker&) = delete;
  BackgroundWorker& operator=(const BackgroundWorker&) = delete;

  enum class Outcome { kTaken, kFull, kStopped };
  // Queues `work` if there is room. `refuse` is called instead if the worker stops before its turn.
  Outcome submit(std::function<void()> work, std::function<void()> refuse);

  // Refuses waiting and later work at once; work in progress continues. Idempotent.
  void close();
  // Calls close() and waits for work in progress. Idempotent; not from within the work.
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
  std::size_t idle_;  // Idle threads.
  bool stopped_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace kerf::picture
