#include "server/service/durable/state_codec.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "kerf/v1/store.pb.h"
#include "server/service/durable/change_codec.h"

namespace kerf::durable {

std::string encode_state(const host::SavedState& state) {
  const host::SavedRun& run = state.run;
  v1::StoredSheetState message;
  message.set_sheet(*run.sheet);
  for (const host::ScheduledCommand& each : run.scheduled) *message.add_scheduled() = encode_scheduled(each);
  message.set_last_schedule_number(run.last_schedule_number);
  message.set_is_changed(run.changes.is_changed());
  message.set_resets(run.changes.resets());
  message.set_resets_undone(run.changes.resets_undone());
  message.mutable_flagged_ticks()->Add(run.flagged_ticks.begin(), run.flagged_ticks.end());
  message.set_recording(run.recording.bytes);
  message.set_recording_last_tick(run.recording.last_tick);
  message.set_recording_given_up_at(run.recording.given_up_at);
  message.set_is_paused(run.paused);
  message.set_speed(run.speed);
  message.mutable_stream_grabs()->Add(run.stream_grabs.begin(), run.stream_grabs.end());
  message.set_attachment(run.attachment);
  message.set_name(state.status.id);
  message.set_tick(state.status.tick);
  message.set_scene_tick(state.status.scene_tick);
  message.set_num_vertices(state.status.num_vertices);
  message.set_state_hash(state.status.state_hash);
  message.set_continuation_hash(state.status.continuation_hash);
  message.set_saved_unix_us(state.status.saved_unix_us);
  return message.SerializeAsString();
}

Result<host::SavedState> decode_state(std::string_view bytes) {
  v1::StoredSheetState message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return data_loss("STATE_DAMAGED", "a stored state is damaged: it is no message");
  }
  host::SavedState state;
  host::SavedRun& run = state.run;
  run.sheet = std::make_shared<const std::string>(std::move(*message.mutable_sheet()));
  for (const v1::ScheduledChange& each : message.scheduled()) {
    KERF_TRY_ASSIGN(host::ScheduledCommand scheduled, decode_scheduled(each));
    run.scheduled.push_back(std::move(scheduled));
  }
  run.last_schedule_number = message.last_schedule_number();
  run.changes = host::SceneChanges(message.is_changed(), message.resets(), message.resets_undone());
  // A newer version may count more flags, an older one fewer.
  const auto num_flags = std::min<std::size_t>(run.flagged_ticks.size(), message.flagged_ticks().size());
  std::copy_n(message.flagged_ticks().begin(), num_flags, run.flagged_ticks.begin());
  run.recording = {std::move(*message.mutable_recording()), message.recording_last_tick(),
                   message.recording_given_up_at()};
  run.paused = message.is_paused();
  run.speed = message.speed();
  run.stream_grabs.assign(message.stream_grabs().begin(), message.stream_grabs().end());
  run.attachment = std::move(*message.mutable_attachment());
  state.status.id = message.name();
  state.status.tick = message.tick();
  state.status.scene_tick = message.scene_tick();
  state.status.num_vertices = message.num_vertices();
  state.status.num_bytes = static_cast<std::int64_t>(run.num_bytes());
  state.status.state_hash = message.state_hash();
  state.status.continuation_hash = message.continuation_hash();
  state.status.saved_unix_us = message.saved_unix_us();
  return state;
}

}  // namespace kerf::durable
