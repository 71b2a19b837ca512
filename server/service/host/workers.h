#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "server/service/host/clock.h"

namespace kerf::host {

// A pool of threads that runs work in strands: what is posted to one strand runs in order, never two at once. In a turn
// a thread runs what waits on a strand as the turn begins; strands get their turns in the order in which they ask.
//
// Long work does not keep the rest waiting. While strands wait and no thread is idle, for each thread that has been at
// one piece of work for longer than a patience another is taken on; the operating system shares the cores among them.
// The thread that was replaced ends after that piece, so that there are as many as before.
class Workers {
  struct Pool;
  struct Order;

 public:
  // Copies post to the same strand. May outlive the Workers.
  class Strand {
   public:
    // False, and nothing is done: the pool was joined.
    bool post(std::function<void()> work) const;

   private:
    friend class Workers;
    Strand(std::shared_ptr<Pool> pool, std::shared_ptr<Order> order);
    std::shared_ptr<Pool> pool_;
    std::shared_ptr<Order> order_;
  };

  struct Options {
    std::int32_t num_threads = 1;  // >= 1
    // On the machine's steady clock, >= 0; 0: no thread is ever taken on.
    Nanoseconds patience{0};
    // Beyond num_threads; with so many at long work, strands wait until a piece ends. A thread costs its stack, and
    // each takes its share of the cores from all others.
    std::size_t max_taken_on = 64;
    // Gives way to all threads that have none: see lower_thread_priority().
    bool is_background = false;
  };
  explicit Workers(const Options& options);
  ~Workers();  // join()
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  Strand make_strand();
  // Threads that run work now, those that are replaced included.
  [[nodiscard]] std::size_t num_threads() const;
  // Blocks until nothing is queued or running. Not from a worker.
  void wait_idle();
  // Runs what is queued, and what that posts, to its end; then ends the threads. Idempotent. Not from a worker.
  void join();

 private:
  explicit Workers(std::shared_ptr<Pool> pool);

  std::shared_ptr<Pool> pool_;
};

}  // namespace kerf::host
