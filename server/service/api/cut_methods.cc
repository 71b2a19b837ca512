#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "kerf/v1/cuts.pb.h"
#include "server/service/api/core.h"
#include "server/service/api/cut_replies.h"
#include "server/service/api/paging.h"
#include "server/service/api/tick_advice.h"
#include "server/service/host/playback.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/reply_codec.h"

// Implements CutService.
namespace kerf::api {
namespace {

// Drops "cut_batch." from the field of an error, because a request has the cuts of a batch directly. An error that a
// sheet was not found gets the field "parent".
Error in_request(Error error) {
  constexpr std::string_view kBatch = "cut_batch.";
  if (error.field.starts_with(kBatch)) error.field.erase(0, kBatch.size());
  return with_field(std::move(error), "parent");
}

Status check_tick(std::int64_t at_tick) {
  if (at_tick >= 0) return Nothing{};
  return invalid_argument("OUT_OF_RANGE", "at_tick is " + std::to_string(at_tick) + "; ticks count from 1", "at_tick");
}

// Makes the answer to a Cut or CutBatch from the results of encode_results().
template <typename Response>
using Encode = Response (*)(const host::CommandResult&, std::vector<v1::CutResult>);

// Adds the applied ones of `cuts`, with their `results`, to the journal.
void keep_applied(CutJournal& journal, const std::string& sheet_id, const scene::CommandReply& reply,
                  std::vector<v1::Cut>&& cuts, const std::vector<v1::CutResult>& results) {
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].status() != v1::CutResult::APPLIED) continue;
    const std::int64_t number = reply.cut ? reply.cut->number : reply.batch[i].number;
    journal.add(sheet_id, reply.beginning, number, std::move(cuts[i]), results[i]);
  }
}

// Applies an undo or redo to the journal.
void keep_undone(CutJournal& journal, const std::string& sheet_id, bool is_redo, const scene::CommandReply& reply) {
  if (reply.undone->reset) return journal.go_to(sheet_id, reply.beginning);
  if (!is_redo) return journal.undo(sheet_id, reply.undone->cuts);
  journal.redo(sheet_id, reply.undone->cuts, {reply.tick, reply.topology_version, wire::encode_hash(reply.state_hash)});
}

// Submits the command and adds its applied cuts to the journal. With a tick it schedules the command instead and
// replies `scheduled`. The cuts are encoded here, not on the sheet's strand.
template <typename Response>
void submit_cut(const std::shared_ptr<ApiCore>& core, const std::string& id, scene::Command command,
                std::int64_t at_tick, const RequestKey& key, Reply<Response> answer, Encode<Response> encode) {
  if (at_tick > 0) {
    const auto encode_number = [id, at_tick](std::int64_t number) {
      Response scheduled;
      scheduled.set_status(v1::CutResult::SCHEDULED);
      scheduled.set_tick(at_tick);
      scheduled.set_scheduled_name(scheduled_name(id, number));
      return scheduled;
    };
    core->host.schedule(
        id, std::move(command), at_tick,
        [answer, encode_number](const Result<std::int64_t>& number) {
          if (!number.ok()) return answer(in_request(number.error()));
          answer(encode_number(*number));
        },
        key.answered_by<std::int64_t>(encode_number));
    return;
  }
  const auto cuts = std::make_shared<std::vector<v1::Cut>>(cuts_of(command));
  core->host.submit(
      id, std::move(command),
      [core, id, answer, encode, cuts](const Result<host::CommandResult>& result) {
        if (!result.ok()) return answer(in_request(result.error()));
        std::vector<v1::CutResult> results = encode_results(id, *result);
        keep_applied(core->journal, id, result->reply, std::move(*cuts), results);
        answer(encode(*result, std::move(results)));
      },
      key.answered_by<host::CommandResult>(
          [id, encode](const host::CommandResult& result) { return encode(result, encode_results(id, result)); }));
}

// Cuts a copy of the sheet. `estimate`: the tick estimate of the sheet itself.
Result<host::CommandResult> result_on(sheet::Sheet& copy, const scene::Command& command,
                                      const host::TickEstimate& estimate) {
  const double before = copy.expected_cost().total();
  const sheet::TickReport report = copy.apply({&command, 1});
  const Result<scene::CommandReply>& reply = report.replies.front();
  KERF_TRY(reply);
  host::CommandResult result{*reply, {}};
  result.timings.tick_before_us = estimate.total_us();
  result.timings.tick_after_us =
      before > 0.0 ? estimate.total_us() * copy.expected_cost().total() / before : estimate.total_us();
  result.timings.budget_us = estimate.budget;
  return result;
}

Status check_validate_only(std::int64_t at_tick) {
  if (at_tick == 0) return Nothing{};
  return invalid_argument("EXCLUSIVE", "validate_only predicts a cut made now; leave at_tick out", "at_tick");
}

v1::CutResult without_name(v1::CutResult result) {
  result.clear_name();
  return result;
}
v1::CreateCutsResponse without_name(v1::CreateCutsResponse response) {
  for (v1::CutResult& result : *response.mutable_results()) result.clear_name();
  return response;
}

// Replies as submit_cut() would, but applies the command to a copy of the sheet.
template <typename Response>
void try_cut(const std::shared_ptr<ApiCore>& core, const std::string& id, scene::Command command, Reply<Response> reply,
             Encode<Response> encode) {
  core->host.status(id, [core, id, reply = std::move(reply), encode,
                         command = std::move(command)](const Result<host::SheetStatus>& status) {
    if (!status.ok()) return reply(in_request(status.error()));
    if (status->replay && status->replay->state == host::ReplayState::kPlaying) {
      return reply(in_request(host::replaying()));
    }
    copy_sheet(core, id, "parent",
               [core, id, reply, encode, command,
                estimate = status->tick_estimate](const Result<std::shared_ptr<sheet::Sheet>>& copy) {
                 if (!copy.ok()) return reply(copy.error());
                 const auto work = [core, id, encode, command, estimate, sheet = *copy]() -> Result<Response> {
                   if (core->stopping) return server_stopping();
                   const Result<host::CommandResult> result = result_on(*sheet, command, estimate);
                   if (!result.ok()) return in_request(result.error());
                   return without_name(encode(*result, encode_results(id, *result)));
                 };
                 in_background<Response>(core->analysis_worker, reply, work, too_many_analyses(*core));
               });
  });
}

template <typename Request>
void submit_undo(const std::shared_ptr<ApiCore>& core, const char* method, const Request& request, bool is_redo,
                 Reply<v1::UndoResult> reply) {
  const Result<std::string> id = addressed_sheet(*core, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  idempotent<v1::UndoResult>(core, method, request, std::move(reply), [&](Reply<v1::UndoResult> answer) {
    core->host.submit(
        *id, is_redo ? scene::Command(scene::RedoCut{}) : scene::Command(scene::UndoCut{}),
        [core, id = *id, is_redo, answer = std::move(answer)](const Result<host::CommandResult>& result) {
          if (!result.ok()) return answer(with_field(result.error(), "parent"));
          keep_undone(core->journal, id, is_redo, result->reply);
          answer(encode_undo(id, *result));
        },
        key_of(method, request)
            .template answered_by<host::CommandResult>(
                [id = *id](const host::CommandResult& result) { return encode_undo(id, result); }));
  });
}

// Parses a page token, the number of the last entry on the page before.
std::optional<std::int64_t> parse_token(const std::string& token) {
  std::int64_t number = 0;
  const char* end = token.data() + token.size();
  const auto [stop, fault] = std::from_chars(token.data(), end, number);
  if (token.empty()) return 0;
  if (fault != std::errc() || stop != end || number < 1) return std::nullopt;
  return number;
}

}  // namespace

void keep_in_journal(ApiCore& core, const std::string& sheet_id, const scene::Command& command,
                     const Result<host::CommandResult>& result, const host::ScheduleId& schedule_id) {
  CutJournal& journal = core.journal;
  if (!result.ok()) {
    v1::ScheduledCuts refused = encode_scheduled(sheet_id, command, schedule_id);
    if (refused.cuts().empty()) return;
    refused.set_state(v1::ScheduledCuts::REFUSED);
    refused.set_reason(result.error().reason);
    refused.set_message(result.error().message);
    refused.set_field(result.error().field);
    return journal.refuse(sheet_id, std::move(refused));
  }
  const scene::CommandReply& reply = result->reply;
  if (const auto* reset = std::get_if<scene::Reset>(&command)) {
    if (reset->repeats) journal.forget(sheet_id);
    return journal.reset(sheet_id, reply.beginning);
  }
  if (reply.undone) {
    return keep_undone(journal, sheet_id, std::holds_alternative<scene::RedoCut>(command), reply);
  }
  std::vector<v1::Cut> cuts = cuts_of(command);
  if (cuts.empty()) return;
  std::vector<v1::CutResult> results = encode_results(sheet_id, *result);
  if (schedule_id.number > 0) {
    for (v1::CutResult& each : results) each.set_scheduled_name(scheduled_name(sheet_id, schedule_id.number));
  }
  keep_applied(journal, sheet_id, reply, std::move(cuts), results);
}

void Api::create_cut(const v1::CreateCutRequest& request, Reply<v1::CutResult> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  if (!request.has_cut())
    return reply(invalid_argument("FIELD_MISSING", "cut must be given, with at least its curve", "cut"));
  if (const Status status = check_tick(request.at_tick()); !status.ok()) return reply(status.error());
  Result<scene::Command> command = wire::decode_cut(request.cut());
  if (!command.ok()) return reply(command.error());
  if (request.validate_only()) {
    if (const Status status = check_validate_only(request.at_tick()); !status.ok()) return reply(status.error());
    if (const Status status = check_request_id(request.request_id()); !status.ok()) return reply(status.error());
    return try_cut<v1::CutResult>(core_, *id, std::move(*command), std::move(reply), encode_one);
  }
  idempotent<v1::CutResult>(core_, "CreateCut", request, std::move(reply), [&](Reply<v1::CutResult> answer) {
    submit_cut<v1::CutResult>(core_, *id, std::move(*command), request.at_tick(), key_of("CreateCut", request),
                              std::move(answer), encode_one);
  });
}

void Api::create_cuts(const v1::CreateCutsRequest& request, Reply<v1::CreateCutsResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  if (const Status status = check_tick(request.at_tick()); !status.ok()) return reply(status.error());
  Result<scene::Command> command = wire::decode_cuts(request.cuts());
  if (!command.ok()) return reply(in_request(command.error()));
  if (request.validate_only()) {
    if (const Status status = check_validate_only(request.at_tick()); !status.ok()) return reply(status.error());
    if (const Status status = check_request_id(request.request_id()); !status.ok()) return reply(status.error());
    return try_cut<v1::CreateCutsResponse>(core_, *id, std::move(*command), std::move(reply), encode_batch);
  }
  idempotent<v1::CreateCutsResponse>(
      core_, "CreateCuts", request, std::move(reply), [&](Reply<v1::CreateCutsResponse> answer) {
        submit_cut<v1::CreateCutsResponse>(core_, *id, std::move(*command), request.at_tick(),
                                           key_of("CreateCuts", request), std::move(answer), encode_batch);
      });
}

void Api::cancel_scheduled_cuts(const v1::CancelScheduledCutsRequest& request, Reply<v1::ScheduledCuts> reply) {
  if (core_->stopping) return reply(server_stopping());
  const Result<ScheduledName> name = parse_scheduled_name(request.name());
  if (!name.ok()) return reply(name.error());
  const Result<std::string> id = addressed_sheet(*core_, sheet_name(name->sheet_id), "name");
  if (!id.ok()) return reply(id.error());
  idempotent<v1::ScheduledCuts>(
      core_, "CancelScheduledCuts", request, std::move(reply), [&](Reply<v1::ScheduledCuts> answer) {
        const auto encode = [id = *id](const host::ScheduledCommand& cancelled) {
          v1::ScheduledCuts message = encode_scheduled(id, cancelled.command, cancelled.id);
          message.set_state(v1::ScheduledCuts::CANCELLED);
          return message;
        };
        core_->host.cancel(
            *id, name->number,
            [encode, answer = std::move(answer)](const Result<host::ScheduledCommand>& cancelled) {
              if (!cancelled.ok()) return answer(with_field(cancelled.error(), "name"));
              answer(encode(*cancelled));
            },
            key_of("CancelScheduledCuts", request).answered_by<host::ScheduledCommand>(encode));
      });
}

void Api::undo_cut(const v1::UndoCutRequest& request, Reply<v1::UndoResult> reply) {
  submit_undo(core_, "UndoCut", request, false, std::move(reply));
}

void Api::redo_cut(const v1::RedoCutRequest& request, Reply<v1::UndoResult> reply) {
  submit_undo(core_, "RedoCut", request, true, std::move(reply));
}

void Api::list_cuts(const v1::ListCutsRequest& request, Reply<v1::ListCutsResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  const Result<std::size_t> size = page_size(request.page_size());
  if (!size.ok()) return reply(size.error());
  const std::optional<std::int64_t> after = parse_token(request.page_token());
  if (!after) return reply(bad_page_token());
  // Runs on the sheet's strand, so that an unknown sheet is refused and all earlier cuts are in the journal.
  core_->host.scheduled(*id, [core = core_, id = *id, size = *size, after = *after,
                              reply = std::move(reply)](const Result<std::vector<host::ScheduledCommand>>& waiting) {
    if (!waiting.ok()) return reply(with_field(waiting.error(), "parent"));
    v1::ListCutsResponse response;
    if (after == 0) {
      for (v1::ScheduledCuts& refused : core->journal.refused(id)) *response.add_scheduled() = std::move(refused);
      for (const host::ScheduledCommand& each : *waiting) {
        *response.add_scheduled() = encode_scheduled(id, each.command, each.id);
      }
    }
    CutJournal::Page page = core->journal.page(id, after, size);
    for (v1::ListCutsResponse::Entry& entry : page.entries) *response.add_cuts() = std::move(entry);
    if (page.more) response.set_next_page_token(std::to_string(page.last));
    reply(std::move(response));
  });
}

void Api::list_pieces(const v1::ListPiecesRequest& request, Reply<v1::ListPiecesResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  const Result<std::size_t> size = page_size(request.page_size());
  if (!size.ok()) return reply(size.error());
  const std::optional<std::int64_t> after = parse_token(request.page_token());
  if (!after) return reply(bad_page_token());
  inspect<v1::ListPiecesResponse>(
      core_, *id,
      [size = *size, after = *after](const sheet::Sheet& sheet) {
        v1::ListPiecesResponse response;
        response.set_tick(sheet.tick());
        response.set_topology_version(sheet.topology_version());
        std::vector<scene::Piece> pieces = sheet.pieces();
        std::erase_if(pieces, [after](const scene::Piece& piece) { return piece.birth.id <= after; });
        std::sort(pieces.begin(), pieces.end(), [](const auto& a, const auto& b) { return a.birth.id < b.birth.id; });
        if (pieces.size() > size) {
          pieces.resize(size);
          response.set_next_page_token(std::to_string(pieces.back().birth.id));
        }
        for (const scene::Piece& piece : pieces) *response.add_pieces() = wire::encode_piece(piece);
        return response;
      },
      "parent", std::move(reply));
}

}  // namespace kerf::api
