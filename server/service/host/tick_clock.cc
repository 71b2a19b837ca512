#include "server/service/host/tick_clock.h"

namespace kerf::host {

void TickClock::pause() {
  mode_ = Mode::kPaused;
  stop();
}

void TickClock::sleep() {
  stop();
  mode_ = Mode::kSleeping;
}

void TickClock::start() {
  stop();
  pace_.start(clock_.now());
  set_timer();
}

void TickClock::stop() {
  ++generation_;
  if (timer_) clock_.cancel(*timer_);
  timer_.reset();
}

void TickClock::set_timer() {
  if (pace_.deadline() > clock_.now()) {
    timer_ = clock_.schedule(pace_.deadline(), [due = due_, call = generation_] { due(call); });
  } else {
    call_now();
  }
}

void TickClock::set_timer_after(std::int64_t periods) {
  timer_ = clock_.schedule(clock_.now() + periods * pace_.period(), [due = due_, call = generation_] { due(call); });
}

bool TickClock::accept(std::uint64_t call) {
  if (call != generation_) return false;
  timer_.reset();
  return true;
}

}  // namespace kerf::host
