#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

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
    if (!raised_) {
      boost::system::error_code cancelled;
      co_await alarm_.async_wait(boost::asio::redirect_error(boost::asio::use_awaitable, cancelled));
    }
    raised_ = false;
  }
  void raise() {
    raised_ = true;
    alarm_.cancel();
  }

 private:
  boost::asio::steady_timer alarm_;  // never expires; cancelled by raise()
  bool raised_ = false;
};

}  // namespace kerf::ws
