#include <ctime>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>

#include "server/service/host/clock.h"

namespace kerf::host {

struct RealClock::Impl {
  std::mutex mutex;
  std::uint64_t next_timer = 1;
  boost::asio::io_context context{1};
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work{context.get_executor()};
  std::map<std::uint64_t, boost::asio::steady_timer> timers;  // Timers that have not fired.
  std::thread thread;
};

RealClock::RealClock() : impl_(std::make_unique<Impl>()) {
  impl_->thread = std::thread([this] { impl_->context.run(); });
}

RealClock::~RealClock() {
  impl_->context.stop();
  impl_->thread.join();
}

Nanoseconds RealClock::now() const {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::steady_clock::now().time_since_epoch());
}

std::int64_t RealClock::unix_us() const {
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

Nanoseconds RealClock::thread_cpu() const {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return std::chrono::seconds(used.tv_sec) + Nanoseconds(used.tv_nsec);
}

TimerId RealClock::schedule(Nanoseconds deadline, std::function<void()> fire) {
  const std::chrono::steady_clock::time_point at(
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(deadline));
  const std::lock_guard lock(impl_->mutex);
  const std::uint64_t id = impl_->next_timer++;
  const auto entry = impl_->timers.emplace(id, boost::asio::steady_timer(impl_->context, at)).first;
  entry->second.async_wait([this, id, fire = std::move(fire)](const boost::system::error_code& error) {
    if (error) return;
    {
      const std::lock_guard inner(impl_->mutex);
      if (impl_->timers.erase(id) == 0) return;  // Cancelled after it had expired.
    }
    fire();
  });
  return TimerId{id};
}

bool RealClock::cancel(TimerId timer) {
  const std::lock_guard lock(impl_->mutex);
  return impl_->timers.erase(static_cast<std::uint64_t>(timer)) != 0;
}

}  // namespace kerf::host
