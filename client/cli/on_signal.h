#pragma once

#include <atomic>
#include <csignal>
#include <functional>
#include <thread>

// Turns Ctrl-C into an orderly end.
namespace kerf::cli {

// Blocks the signals of Ctrl-C and SIGTERM in this thread and in threads that it starts later; returns these signals.
sigset_t block_interrupts();

// Waits on its own thread for `signals`, which must be blocked, and calls `act` at the first. A second signal ends the
// program at once.
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
