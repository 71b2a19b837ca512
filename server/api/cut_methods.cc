#include <charconv>
#include <optional>

#include "kerf/v1/cuts.pb.h"
#include "server/api/core.h"
#include "server/api/paging.h"
#include "server/wire/command_codec.h"
#include "server/wire/reply_codec.h"

// CutService.
namespace kerf::api {
namespace {

v1::CutResult encode_result(const std::string& sheet_id, const host::CommandResult& result) {
  v1::CutResult message = wire::encode_cut_result(result.reply);
  if (message.status() == v1::CutResult::APPLIED) {
    message.set_name(cut_name(sheet_id, result.reply.topology_version));
  }
  message.set_queued_us(result.timings.queued_us);
  message.set_cut_us(result.timings.cut_us);
  message.set_update_us(result.timings.update_us);
  return message;
}

// The token is the topology version of the last cut on the page before.
std::optional<std::int32_t> parse_token(const std::string& token) {
  std::int32_t version = 0;
  const char* end = token.data() + token.size();
  const auto [stop, fault] = std::from_chars(token.data(), end, version);
  if (token.empty()) return 0;
  if (fault != std::errc() || stop != end || version < 1) return std::nullopt;
  return version;
}

}  // namespace

void keep_in_journal(ApiCore& core, const std::string& sheet_id, const sheet::Command& command,
                     const host::CommandResult& result) {
  if (std::holds_alternative<sheet::Reset>(command)) return core.journal.forget(sheet_id);
  if (!result.reply.cut || result.reply.cut->status != cut::CutStatus::kApplied) return;
  core.journal.add(sheet_id, wire::encode_command(command).cut(), encode_result(sheet_id, result));
}

void Api::create_cut(const v1::CreateCutRequest& request, Reply<v1::CutResult> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  if (!request.has_cut())
    return reply(invalid_argument("FIELD_MISSING", "cut must be given: its curve at least", "cut"));
  Result<sheet::Command> command = wire::decode_cut(request.cut());
  if (!command.ok()) return reply(command.error());
  once<v1::CutResult>(core_, "CreateCut", request, std::move(reply), [&](Reply<v1::CutResult> answer) {
    core_->host.submit(*id, std::move(*command),
                       [id = *id, answer = std::move(answer)](Result<host::CommandResult> result) {
                         if (!result.ok()) return answer(at_field(result.error(), "parent"));
                         answer(encode_result(id, *result));
                       });
  });
}

void Api::list_cuts(const v1::ListCutsRequest& request, Reply<v1::ListCutsResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  const Result<std::size_t> size = page_size(request.page_size());
  if (!size.ok()) return reply(size.error());
  const std::optional<std::int32_t> after = parse_token(request.page_token());
  if (!after) return reply(bad_page_token());
  // By way of the sheet: an unknown one is refused, and all cuts done before this call are in the journal.
  look_at<bool>(
      core_, *id, [](const sheet::Sheet&) { return true; }, "parent",
      [core = core_, id = *id, size = *size, after = *after, reply = std::move(reply)](const Result<bool>& exists) {
        if (!exists.ok()) return reply(exists.error());
        CutJournal::Page page = core->journal.page(id, after, size);
        v1::ListCutsResponse response;
        for (v1::ListCutsResponse::Entry& entry : page.entries) *response.add_cuts() = std::move(entry);
        if (page.more) {
          const auto& last = response.cuts(response.cuts_size() - 1);
          response.set_next_page_token(std::to_string(last.result().topology_version()));
        }
        reply(std::move(response));
      });
}

}  // namespace kerf::api
