#include "server/service/durable/change_codec.h"

#include <utility>

#include "kerf/v1/store.pb.h"
#include "server/base/overloaded.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/recording_codec.h"

namespace kerf::durable {

namespace {

Error damaged(const std::string& what) {
  return data_loss("CHANGE_DAMAGED", "a stored change is damaged: " + what);
}

v1::TickChange encode_tick(const host::TickEvent& tick) {
  v1::TickChange message;
  for (const scene::Command& command : tick.commands) *message.add_commands() = wire::encode_command(command);
  for (const host::SettledCommand& settled : tick.settled) {
    v1::SettledCommand& each = *message.add_settled();
    each.set_index(static_cast<std::int32_t>(settled.index));
    each.set_number(settled.id.number);
    each.set_at_tick(settled.id.at_tick);
  }
  for (const std::size_t index : tick.of_streams) message.add_of_streams(static_cast<std::int32_t>(index));
  message.set_is_apply(tick.is_apply);
  return message;
}

}  // namespace

v1::ScheduledChange encode_scheduled(const host::ScheduledCommand& scheduled) {
  v1::ScheduledChange message;
  message.set_number(scheduled.id.number);
  message.set_at_tick(scheduled.id.at_tick);
  *message.mutable_command() = wire::encode_command(scheduled.command);
  return message;
}

Result<host::ScheduledCommand> decode_scheduled(const v1::ScheduledChange& message) {
  Result<scene::Command> command = wire::decode_command(message.command());
  if (!command.ok()) return damaged("a command is refused: " + command.error().message);
  return host::ScheduledCommand{{message.at_tick(), message.number()}, std::move(*command)};
}

namespace {

Result<host::SheetEvent> decode_tick(const v1::TickChange& message) {
  host::TickEvent tick;
  for (const v1::Command& each : message.commands()) {
    Result<scene::Command> command = wire::decode_command(each);
    if (!command.ok()) return damaged("a command is refused: " + command.error().message);
    tick.commands.push_back(std::move(*command));
  }
  const auto is_command = [&](std::int32_t index) { return index >= 0 && index < message.commands_size(); };
  for (const v1::SettledCommand& settled : message.settled()) {
    if (!is_command(settled.index())) return damaged("it has no such command");
    tick.settled.push_back({static_cast<std::size_t>(settled.index()), {settled.at_tick(), settled.number()}});
  }
  for (const std::int32_t index : message.of_streams()) {
    if (!is_command(index)) return damaged("it has no such command");
    tick.of_streams.push_back(static_cast<std::size_t>(index));
  }
  tick.is_apply = message.is_apply();
  return host::SheetEvent(std::move(tick));
}

}  // namespace

std::string encode_change(const host::SheetEvent& event) {
  v1::StoredChange message;
  std::visit(Overloaded{
                 [&](const host::TickEvent& tick) { *message.mutable_tick() = encode_tick(tick); },
                 [&](const host::ScheduledCommand& each) { *message.mutable_scheduled() = encode_scheduled(each); },
                 [&](const host::CancelEvent& cancel) { message.set_cancelled(cancel.number); },
                 [&](const host::RunEvent& run) {
                   message.mutable_run()->set_is_paused(run.is_paused);
                   message.mutable_run()->set_speed(run.speed);
                 },
                 [&](const host::RestoreEvent&) { message.mutable_restore(); },
             },
             event);
  return message.SerializeAsString();
}

Result<host::SheetEvent> decode_change(std::string_view bytes) {
  v1::StoredChange message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return damaged("it is no message");
  switch (message.change_case()) {
    case v1::StoredChange::kTick:
      return decode_tick(message.tick());
    case v1::StoredChange::kScheduled: {
      KERF_TRY_ASSIGN(host::ScheduledCommand scheduled, decode_scheduled(message.scheduled()));
      return host::SheetEvent(std::move(scheduled));
    }
    case v1::StoredChange::kRestore:
      return host::SheetEvent(host::RestoreEvent{});
    case v1::StoredChange::kCancelled:
      return host::SheetEvent(host::CancelEvent{message.cancelled()});
    case v1::StoredChange::kRun:
      return host::SheetEvent(host::RunEvent{message.run().is_paused(), message.run().speed()});
    case v1::StoredChange::CHANGE_NOT_SET:
      break;
  }
  return damaged("it is of a kind that this version does not know");
}

std::string encode_stored_scene(const scene::SheetConfig& config) {
  return wire::encode_recording_header(config, wire::build_name());
}

Result<scene::SheetConfig> decode_stored_scene(std::string_view bytes) {
  KERF_TRY_ASSIGN(wire::RecordingFile file, wire::decode_recording(bytes));
  return std::move(file.recording.config);
}

}  // namespace kerf::durable
