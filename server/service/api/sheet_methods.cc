#include <algorithm>

#include "google/protobuf/empty.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "server/service/api/core.h"
#include "server/service/api/gltf_file.h"
#include "server/service/api/paging.h"
#include "server/service/api/sheet_files.h"
#include "server/service/wire/scene_codec.h"

// Implements SheetService.
namespace kerf::api {

void make_sheet(const std::shared_ptr<ApiCore>& core, v1::CreateSheetRequest request, Reply<v1::Sheet> reply,
                const std::stop_token& stop) {
  if (core->stopping) return reply(server_stopping());
  const std::string& id = request.sheet_id();
  if (const Status valid = check_sheet_id(id); !valid.ok()) return reply(valid.error());
  if (!request.has_scene()) {
    return reply(invalid_argument("FIELD_MISSING", "scene must be given, with at least a mesh", "scene"));
  }
  // Copies the scene if there is a request_id, which stands for the whole request.
  v1::Scene scene = request.request_id().empty() ? std::move(*request.mutable_scene()) : request.scene();
  Result<scene::SheetConfig> config = wire::decode_scene(std::move(scene));
  const auto in_scene = [](Error error) {
    const bool about_scene = error.code == ErrorCode::kInvalidArgument;
    if (about_scene) error.field = error.field.empty() ? "scene" : "scene." + error.field;
    return error;
  };
  if (!config.ok()) return reply(in_scene(config.error()));
  const RequestKey key = key_of("CreateSheet", request);
  const auto create = [&](Reply<v1::Sheet> answer, const std::stop_token& all_left) {
    core->host.create_sheet(
        id, std::move(*config), request.paused(),
        [answer = std::move(answer), in_scene](Result<host::SheetStatus> status) {
          if (!status.ok()) return answer(in_scene(status.error()));
          answer(encode_sheet(*status));
        },
        all_left, key.answered_by<host::SheetStatus>(encode_sheet));
  };
  idempotent_while_wanted<v1::Sheet>(core, "CreateSheet", request, std::move(reply), stop, create);
}

void Api::create_sheet(const v1::CreateSheetRequest& request, Reply<v1::Sheet> reply, std::stop_token stop) {
  make_sheet(core_, request, std::move(reply), stop);
}

void Api::get_sheet(const v1::GetSheetRequest& request, Reply<v1::Sheet> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  core_->host.status(*id, sheet_reply(std::move(reply), "name"));
}

void Api::list_sheets(const v1::ListSheetsRequest& request, const auth::Caller& caller,
                      Reply<v1::ListSheetsResponse> reply) {
  if (core_->stopping) return reply(server_stopping());
  const Result<std::size_t> size = page_size(request.page_size());
  if (!size.ok()) return reply(size.error());
  if (!request.page_token().empty() && !scene::is_valid_sheet_id(request.page_token())) {
    return reply(bad_page_token());
  }
  // Uses the last id of the page before as token, so that sheets made or deleted in between shift nothing.
  std::vector<std::string> ids = core_->host.list();
  std::erase_if(ids, [&caller](const std::string& id) { return !caller->rights().reaches(id); });
  ids.erase(ids.begin(), std::upper_bound(ids.begin(), ids.end(), request.page_token()));
  const bool more = ids.size() > *size;
  if (more) ids.resize(*size);
  v1::ListSheetsResponse response;
  if (more) response.set_next_page_token(ids.back());
  for (const host::SheetStatus& status : core_->host.statuses(ids)) *response.add_sheets() = encode_sheet(status);
  reply(std::move(response));
}

void Api::delete_sheet(const v1::DeleteSheetRequest& request, Reply<google::protobuf::Empty> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  const auto deleted = [reply = std::move(reply)](const Status& status) {
    if (!status.ok()) return reply(with_field(status.error(), "name"));
    reply(google::protobuf::Empty());
  };
  // Forgets the journal before the name is free, so that the cuts of a new sheet stay.
  core_->host.delete_sheet(*id, deleted, [core = core_, id = *id] {
    core->journal.forget(id);
    core->audience->forget(id);
  });
}

void Api::pause_sheet(const v1::PauseSheetRequest& request, Reply<v1::Sheet> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  core_->host.pause(*id, sheet_reply(std::move(reply), "name"));
}

void Api::resume_sheet(const v1::ResumeSheetRequest& request, Reply<v1::Sheet> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  core_->host.resume(*id, sheet_reply(std::move(reply), "name"));
}

void Api::set_sheet_speed(const v1::SetSheetSpeedRequest& request, Reply<v1::Sheet> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  core_->host.set_speed(*id, request.speed(), sheet_reply(std::move(reply), "name"));
}

void Api::reset_sheet(const v1::ResetSheetRequest& request, Reply<v1::Sheet> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  core_->host.submit(*id, scene::Reset{},
                     [core = core_, id = *id, reply = std::move(reply)](const Result<host::CommandResult>& result) {
                       if (!result.ok()) return reply(with_field(result.error(), "name"));
                       core->journal.reset(id, result->reply.beginning);
                       core->host.status(id, sheet_reply(reply, "name"));
                     });
}

void Api::get_sheet_state(const v1::GetSheetStateRequest& request, Reply<v1::SheetState> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  inspect<v1::SheetState>(
      core_, *id,
      [name = request.name()](const sheet::Sheet& sheet) {
        v1::SheetState state = encode_exact_state(sheet);
        state.set_name(name);
        return state;
      },
      "name", std::move(reply));
}

void Api::export_sheet(const v1::ExportSheetRequest& request, Reply<v1::ExportSheetResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  if (!v1::ExportSheetRequest::Format_IsValid(request.format())) {
    return reply(invalid_argument("UNKNOWN_ENUM_VALUE", "format must be OBJ or GLTF", "format"));
  }
  using Found = std::shared_ptr<const sheet::Snapshot>;
  inspect<Found>(
      core_, *id, [](const sheet::Sheet& sheet) { return sheet.snapshot(); }, "name",
      [core = core_, format = request.format(), reply = std::move(reply)](Result<Found> found) {
        if (!found.ok()) return reply(found.error());
        in_background<v1::ExportSheetResponse>(
            core->file_worker, reply,
            [format, snapshot = *found] {
              const bool is_gltf = format == v1::ExportSheetRequest::GLTF;
              v1::ExportSheetResponse response;
              response.set_content(is_gltf ? encode_gltf(*snapshot) : encode_obj(*snapshot));
              response.set_media_type(is_gltf ? "model/gltf-binary" : "model/obj");
              return response;
            },
            too_many_files(*core));
      });
}

}  // namespace kerf::api
