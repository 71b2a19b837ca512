#pragma once

#include <cstdint>
#include <functional>
#include <memory>

namespace kerf::host {

// A pool of threads that runs work in strands: what is posted to one strand runs in order, never two at once.
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

  explicit Workers(std::int32_t num_threads);  // >= 1
  ~Workers();                                  // join()
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  Strand make_strand();
  // Blocks until nothing is queued or running. Not from a worker.
  void wait_idle();
  // Runs what is queued, and what that posts, to its end; then ends the threads. Idempotent. Not from a worker.
  void join();

 private:
  std::shared_ptr<Pool> pool_;
};

}  // namespace kerf::host
