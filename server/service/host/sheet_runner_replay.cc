#include <utility>

#include "server/service/host/sheet_runner.h"

// Runs the ticks of a SheetRunner that plays a recording.
namespace kerf::host {

bool SheetRunner::play_tick() {
  if (!play_applied()) return false;
  if (is_playing() && !tick_played_) {
    const bool has_entry = playback_->next_at(sheet_.tick() + 1) != nullptr;
    if (!(has_entry ? play_entry(true) : run_commands(true, {}))) return false;
    tick_played_ = true;
    if (!play_applied()) return false;
  }
  if (is_playing() && sheet_.frozen()) playback_->stuck(sheet_.tick(), sheet_.state_hash());
  tick_played_ = false;
  if (!is_playing()) end_playback();
  return true;
}

// Plays the entries applied while time stood still. There may be any number of them; one turn plays a few.
bool SheetRunner::play_applied() {
  for (std::int32_t i = 0; playback_->next_at(sheet_.tick()) != nullptr; ++i) {
    if (i == Host::kEntriesPerTurn || context_.stopping || closing_) return false;
    play_entry(false);
  }
  return true;
}

bool SheetRunner::play_entry(bool advance) {
  const sheet::RecordedTick& entry = *playback_->next_at(sheet_.tick() + (advance ? 1 : 0));
  std::vector<Pending> pending;
  pending.reserve(entry.commands.size());
  for (const sheet::Command& command : entry.commands) {
    pending.push_back({command, {}, context_.clock.now()});
  }
  if (!run_commands(advance, std::move(pending))) {
    if (sheet_.frozen()) playback_->stuck(sheet_.tick(), sheet_.state_hash());
    return false;
  }
  playback_->passed(sheet_.tick(), sheet_.state_hash());
  return true;
}

// Pauses the sheet, which takes commands from clients from here on.
void SheetRunner::end_playback() {
  if (step_call_) step_call_->remaining = 0;
  ++state_changes_;
  if (paused_) {
    note_status();
    publish();
  } else {
    pause();
  }
}

}  // namespace kerf::host
