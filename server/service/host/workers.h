#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/service/host/clock.h"

namespace kerf::host {

// Runs work on a pool of threads, in strands: work posted to one strand runs in order, never two pieces at once. In a
// turn a thread runs the pieces that wait on a strand as the turn begins. Strands get turns in the order of their
// requests, and groups of strands in turns, see FairQueue.
//
// Long work does not delay the rest. While strands wait and no thread is idle, each thread busy with one piece for
// longer than `long_work` is replaced by a new one. The operating system shares the cores among them. The replaced
// thread ends after its piece, so the number of threads returns to normal.
class Workers {
  struct Pool;
  struct Order;

 public:
  // Copies post to the same strand. May outlive the Workers.
  class Strand {
   public:
    // Returns false and does nothing if the pool was joined.
    bool post(std::function<void()> work) const;

   private:
    friend class Workers;
    Strand(std::shared_ptr<Pool> pool, std::shared_ptr<Order> order);
    std::shared_ptr<Pool> pool_;
    std::shared_ptr<Order> order_;
  };

  struct Options {
    std::int32_t num_threads = 1;  // >= 1
    // Time at one piece of work after which its thread is replaced, on the machine's steady clock, >= 0; 0: no thread
    // is ever added.
    Nanoseconds long_work{0};
    // Limit on threads beyond num_threads; while that many are busy with long work, strands wait until a piece ends.
    // Each thread costs its stack and takes a share of the cores from the others.
    std::size_t max_taken_on = 64;
    // Lowers the priority of the threads: see lower_thread_priority().
    bool is_background = false;
  };
  explicit Workers(const Options& options);
  ~Workers();  // join()
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  // Returns a new strand. Strands of different groups share the threads in equal parts of the time, if all have work.
  Strand make_strand(const std::string& group = {});
  // Returns the number of threads, including replaced ones still at work.
  [[nodiscard]] std::size_t num_threads() const;
  // Blocks until no work is queued or running. Not from a worker.
  void wait_idle();
  // Runs all queued work, and the work that it posts, to its end; then ends the threads. Idempotent. Not from a worker.
  void join();

 private:
  explicit Workers(std::shared_ptr<Pool> pool);

  std::shared_ptr<Pool> pool_;
};

}  // namespace kerf::host
