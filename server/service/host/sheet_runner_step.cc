#include <string>
#include <utility>

#include "server/service/host/sheet_runner.h"

// Runs the step() calls of a SheetRunner, a few ticks per turn.
namespace kerf::host {

void SheetRunner::step(std::int64_t ticks, Callback<SheetStatus> done, std::stop_token stop) {
  const auto refuse = [&](const char* reason, const char* message) { done(failed_precondition(reason, message)); };
  if (!paused_) return refuse("NOT_PAUSED", "only a paused sheet can be stepped; pause it first");
  if (step_call_) return refuse("STEPPING", "the sheet is already being stepped; wait for that call");
  if (sheet_.frozen()) return refuse("SHEET_FROZEN", "the sheet is frozen at its last good tick; reset it first");
  step_call_ = StepCall{ticks, std::move(done), std::move(stop)};
  if (!turn_posted_)
    keep_or_lose([this] { take_turn(); });  // Otherwise the turn left by an ended call serves this one.
}

void SheetRunner::take_turn() {
  if (closed_ || !step_call_) return;
  for (std::int32_t i = 0; i < Host::kTicksPerTurn && step_call_->remaining > 0; ++i) {
    if (context_.stopping) return;                     // close() answers the call.
    if (pauses_waiting_ > 0 && was_tick_long_) break;  // A turn of short ticks ends soon anyway.
    if (step_call_->stop.stop_requested()) return finish_step(status());
    if (!run_once(true)) break;
    --step_call_->remaining;  // Negative if the tick has ended the call.
    if (!sheet_.frozen()) continue;
    finish_step(failed_precondition("SHEET_FROZEN", "no finite step, or no memory for one, was found at tick " +
                                                        std::to_string(sheet_.tick()) +
                                                        "; the sheet is frozen there: reset it"));
    return;
  }
  if (step_call_->remaining > 0) {
    turn_posted_ = strand_.post([self = shared_from_this()] {
      self->turn_posted_ = false;
      self->keep_or_lose([&] { self->take_turn(); });
    });
    return;
  }
  finish_step(status());
}

void SheetRunner::finish_step(Result<SheetStatus> result) {
  const Callback<SheetStatus> done = std::move(step_call_->done);
  step_call_.reset();
  tick_played_ = false;
  note_state();
  done(std::move(result));
  commands_arrived();
}

}  // namespace kerf::host
