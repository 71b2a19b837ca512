#include "client/cli/on_signal.h"

#include <ctime>
#include <utility>

namespace kerf::cli {

sigset_t block_interrupts() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

OnSignal::OnSignal(const sigset_t& signals, std::function<void()> act) : signals_(signals), act_(std::move(act)) {
  thread_ = std::thread([this] { run(); });
}

OnSignal::~OnSignal() {
  over_ = true;
  thread_.join();
}

void OnSignal::run() {
  const timespec wait{0, 100'000'000};
  while (!over_ && !came_) {
    if (sigtimedwait(&signals_, nullptr, &wait) < 0) continue;
    came_ = true;
    act_();
  }
  // Unblocks the signals on this thread, so that the next one ends the program.
  if (came_) pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
  while (!over_) nanosleep(&wait, nullptr);
}

}  // namespace kerf::cli
