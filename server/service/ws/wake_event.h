#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include <chrono>
#include <utility>

namespace kerf::ws {

// Wakes one coroutine from others. All calls are on one strand.
class WakeEvent {
 public:
  template <typename Executor>
  explicit WakeEvent(const Executor& executor) : alarm_(executor) {
    alarm_.expires_at(boost::asio::steady_timer::time_point::max());
  }

  // Waits until raise() has been called since the last wait.
  boost::asio::awaitable<void> wait() {
    co_await wait_for_alarm();
    raised_ = false;
  }
  // Waits as wait() does, for at most `timeout`; returns true if raise() was called.
  boost::asio::awaitable<bool> wait_for(std::chrono::milliseconds timeout) {
    alarm_.expires_after(timeout);
    co_await wait_for_alarm();
    alarm_.expires_at(boost::asio::steady_timer::time_point::max());
    co_return std::exchange(raised_, false);
  }
  void raise() {
    raised_ = true;
    alarm_.cancel();
  }

 private:
  boost::asio::awaitable<void> wait_for_alarm() {
    if (raised_) co_return;
    boost::system::error_code cancelled;
    co_await alarm_.async_wait(boost::asio::redirect_error(boost::asio::use_awaitable, cancelled));
  }

  boost::asio::steady_timer alarm_;  // Expires in wait_for() only; cancelled by raise().
  bool raised_ = false;
};

}  // namespace kerf::ws
