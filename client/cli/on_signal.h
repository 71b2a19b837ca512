#pragma once

#include <atomic>
#include <csignal>
#include <functional>
#include <thread>

// Ctrl-C as an orderly end of what goes on.
namespace kerf::cli {

// Ctrl-C and SIGTERM, blocked in this thread and those that it starts from now on.
sigset_t block_interrupts();

// Calls `act` at the first of the signals, in a thread of its own. A second one ends the program at once.
class OnSignal {
 public:
  OnSignal(const sigset_t& signals, std::function<void()> act);
  ~OnSignal();
  OnSignal(const OnSignal&) = delete;
  OnSignal& operator=(const OnSignal&) = delete;
  [[nodiscard]] bool came() const { return came_; }

 private:
  void run();

  const sigset_t signals_;
  const std::function<void()> act_;
  std::atomic<bool> over_{false};
  std::atomic<bool> came_{false};
  std::thread thread_;
};

}  // namespace kerf::cli
