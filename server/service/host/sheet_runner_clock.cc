#include <algorithm>

#include "server/service/host/sheet_runner.h"

// Schedules the ticks of a SheetRunner.
namespace kerf::host {

void SheetRunner::set_speed(double speed) {
  if (speed == pace_.speed()) return;
  pace_.set_speed(speed, context_.clock.now());
  need_.set_period(pace_.period());
  if (ticks_by_clock()) {
    stop_clock();
    note_need(need_.value());
    schedule();
  }
  ++state_changes_;
  note_status();
  publish();
}

bool SheetRunner::ticks_by_clock() const {
  return run_state() == RunState::kRunning && !step_call_;
}

bool SheetRunner::may_repeat() const {
  if (sheet_.config().repeat_after == 0 || is_changed_ || paused_ || step_call_ || is_playing()) return false;
  return std::any_of(sinks_.begin(), sinks_.end(), [](const auto& sink) { return sink->wants_snapshot(); });
}

void SheetRunner::repeat_if_over() {
  if (!sleeping_ || timer_ || !may_repeat()) return;
  repeats_now_ = true;
  wake();
}

void SheetRunner::await_repeat() {
  if (sheet_.config().repeat_after == 0) return;
  const std::int64_t ticks = std::max<std::int64_t>(sheet_.config().repeat_after - sheet_.scene_tick(), 0);
  timer_ = context_.clock.schedule(context_.clock.now() + ticks * pace_.period(), deadline_call());
}

void SheetRunner::wake() {
  sleeping_ = false;
  note_state();
  start_clock();
}

void SheetRunner::start_clock() {
  stop_clock();
  pace_.start(context_.clock.now());
  note_need(need_.value());
  schedule();
}

void SheetRunner::stop_clock() {
  ++generation_;
  if (timer_) context_.clock.cancel(*timer_);
  timer_.reset();
  note_need(0);
}

void SheetRunner::schedule() {
  if (pace_.deadline() > context_.clock.now()) {
    timer_ = context_.clock.schedule(pace_.deadline(), deadline_call());
  } else {
    deadline_call()();
  }
}

std::function<void()> SheetRunner::deadline_call() {
  return [weak = weak_from_this(), strand = strand_, generation = generation_] {
    strand.post([weak, generation] {
      if (const auto self = weak.lock()) self->on_deadline(generation);
    });
  };
}

}  // namespace kerf::host
