#include "server/host/workers.h"

#include <condition_variable>
#include <mutex>
#include <utility>

#include <boost/asio/post.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/thread_pool.hpp>

#include "server/base/check.h"

namespace kerf::host {

struct Workers::Pool {
  explicit Pool(std::int32_t num_threads) : threads(static_cast<std::size_t>(num_threads)) {}

  // Whether the work may be posted; if so it counts as outstanding until finish().
  bool begin() {
    const std::lock_guard lock(mutex);
    if (closed) return false;
    ++outstanding;
    return true;
  }
  void finish() {
    const std::lock_guard lock(mutex);
    if (--outstanding == 0) idle.notify_all();
  }

  std::mutex mutex;
  std::condition_variable idle;
  std::int64_t outstanding = 0;  // posted and not finished
  bool closed = false;
  boost::asio::thread_pool threads;
};

struct Workers::Order {
  boost::asio::strand<boost::asio::thread_pool::executor_type> strand;
};

Workers::Strand::Strand(std::shared_ptr<Pool> pool, std::shared_ptr<Order> order)
    : pool_(std::move(pool)), order_(std::move(order)) {}

bool Workers::Strand::post(std::function<void()> work) const {
  if (!pool_->begin()) return false;
  // The pool outlives its queue: a raw pointer is enough, and a shared one could make the last owner a worker.
  boost::asio::post(order_->strand, [pool = pool_.get(), work = std::move(work)]() mutable {
    work();
    work = nullptr;  // what it holds goes before the pool may be taken for idle
    pool->finish();
  });
  return true;
}

Workers::Workers(std::int32_t num_threads) {
  KERF_CHECK(num_threads >= 1, "a pool without threads never finishes anything");
  pool_ = std::make_shared<Pool>(num_threads);
}

Workers::~Workers() {
  join();
}

Workers::Strand Workers::make_strand() {
  return {pool_, std::make_shared<Order>(Order{boost::asio::make_strand(pool_->threads.get_executor())})};
}

void Workers::wait_idle() {
  std::unique_lock lock(pool_->mutex);
  pool_->idle.wait(lock, [&] { return pool_->outstanding == 0; });
}

void Workers::join() {
  {
    std::unique_lock lock(pool_->mutex);
    pool_->idle.wait(lock, [&] { return pool_->outstanding == 0; });
    pool_->closed = true;
  }
  pool_->threads.join();
}

}  // namespace kerf::host
