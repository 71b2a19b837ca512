#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include <chrono>
#include <utility>

namespace kerf::ws {

// What one coroutine waits for and others raise. All on one strand.
class WakeSignal {
 public:
  template <typename Executor>
  explicit WakeSignal(const Executor& executor) : alarm_(executor) {
    alarm_.expires_at(boost::asio::steady_timer::time_point::max());
  }

  // Returns once it was raised since the last wait().
  boost::asio::awaitable<void> wait() {
    co_await wait_for_alarm();
    raised_ = false;
  }
  // The same, or after `patience`; whether it was raised.
  boost::asio::awaitable<bool> wait_for(std::chrono::milliseconds patience) {
    alarm_.expires_after(patience);
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

  boost::asio::steady_timer alarm_;  // expires in wait_for() alone; cancelled by raise()
  bool raised_ = false;
};

}  // namespace kerf::ws
