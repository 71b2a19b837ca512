#pragma once

#include <atomic>
#include <csignal>
#include <functional>
#include <thread>

// Turns Ctrl-C into an orderly end.
namespace kerf::cli {

// Blocks Ctrl-C and SIGTERM in this thread and those started later; returns them.
sigset_t block_interrupts();

// Calls `act` at the first of the signals, on its own thread. A second one ends the program at once.
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
