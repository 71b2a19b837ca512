#include "server/service/api/cut_replies.h"

#include <algorithm>
#include <string>
#include <utility>

#include "server/service/api/resource_names.h"
#include "server/service/api/tick_advice.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/reply_codec.h"

namespace kerf::api {

std::vector<v1::CutResult> encode_results(const std::string& sheet_id, const host::CommandResult& result) {
  const scene::CommandReply& reply = result.reply;
  std::vector<v1::CutResult> messages = wire::encode_cut_results(reply);
  const auto count = static_cast<double>(messages.size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    v1::CutResult& message = messages[i];
    const std::int64_t number = reply.cut ? reply.cut->number : reply.batch[i].number;
    if (message.status() == v1::CutResult::APPLIED) message.set_name(cut_name(sheet_id, number));
    message.set_queued_us(result.timings.queued_us);
    message.set_cut_us(result.timings.cut_us / count);
    message.set_update_us(result.timings.update_us / count);
    message.set_tick_before_us(result.timings.tick_before_us);
    message.set_tick_after_us(result.timings.tick_after_us);
    message.set_tick_budget_us(result.timings.budget_us);
  }
  const std::string warning = warning_of_slower_ticks(result.timings);
  const auto last = std::find_if(messages.rbegin(), messages.rend(), [](const v1::CutResult& message) {
    return message.status() == v1::CutResult::APPLIED;
  });
  if (!warning.empty() && last != messages.rend()) last->add_warnings(warning);
  return messages;
}

v1::CreateCutsResponse encode_batch(const host::CommandResult& result, std::vector<v1::CutResult> results) {
  v1::CreateCutsResponse response;
  response.set_tick(result.reply.tick);
  response.set_topology_version(result.reply.topology_version);
  response.set_state_hash(wire::encode_hash(result.reply.state_hash));
  response.set_queued_us(result.timings.queued_us);
  response.set_cut_us(result.timings.cut_us);
  response.set_update_us(result.timings.update_us);
  response.set_tick_before_us(result.timings.tick_before_us);
  response.set_tick_after_us(result.timings.tick_after_us);
  response.set_tick_budget_us(result.timings.budget_us);
  for (v1::CutResult& message : results) {
    if (message.status() == v1::CutResult::APPLIED) response.set_applied(response.applied() + 1);
    response.set_pieces(message.pieces());
    response.set_new_vertices(response.new_vertices() + message.new_vertices());
    response.set_new_triangles(response.new_triangles() + message.new_triangles());
    *response.add_results() = std::move(message);
  }
  response.set_status(response.applied() > 0 ? v1::CutResult::APPLIED : v1::CutResult::NO_INTERSECTION);
  return response;
}

v1::CutResult encode_one(const host::CommandResult& /*result*/, std::vector<v1::CutResult> results) {
  return std::move(results.front());
}

v1::UndoResult encode_undo(const std::string& sheet_id, const host::CommandResult& result) {
  const scene::UndoReply& undone = *result.reply.undone;
  v1::UndoResult message;
  for (const std::int64_t number : undone.cuts) message.add_cuts(cut_name(sheet_id, number));
  message.set_reset(undone.reset);
  message.set_tick(result.reply.tick);
  message.set_topology_version(result.reply.topology_version);
  message.set_pieces(undone.pieces);
  message.set_state_hash(wire::encode_hash(result.reply.state_hash));
  message.set_undo_steps(undone.undo_steps);
  message.set_redo_steps(undone.redo_steps);
  message.set_queued_us(result.timings.queued_us);
  message.set_cut_us(result.timings.cut_us);
  message.set_update_us(result.timings.update_us);
  message.set_tick_before_us(result.timings.tick_before_us);
  message.set_tick_after_us(result.timings.tick_after_us);
  message.set_tick_budget_us(result.timings.budget_us);
  return message;
}

std::vector<v1::Cut> cuts_of(const scene::Command& command) {
  std::vector<v1::Cut> cuts;
  if (const auto* cut = std::get_if<scene::Cut>(&command)) cuts.push_back(wire::encode_cut(*cut));
  if (const auto* batch = std::get_if<scene::CutBatch>(&command)) {
    for (const scene::Cut& cut : batch->cuts) cuts.push_back(wire::encode_cut(cut));
  }
  return cuts;
}

v1::ScheduledCuts encode_scheduled(const std::string& sheet_id, const scene::Command& command,
                                   const host::ScheduleId& schedule_id) {
  v1::ScheduledCuts message;
  message.set_state(v1::ScheduledCuts::WAITING);
  message.set_tick(schedule_id.at_tick);
  if (schedule_id.number > 0) message.set_name(scheduled_name(sheet_id, schedule_id.number));
  for (v1::Cut& cut : cuts_of(command)) *message.add_cuts() = std::move(cut);
  return message;
}

}  // namespace kerf::api
