#include "google/protobuf/empty.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "server/service/api/core.h"
#include "server/service/wire/reply_codec.h"

// Implements the methods of SheetService for saved states. Each state has the sheet's list of cuts attached.
namespace kerf::api {
namespace {

v1::SavedState encode_state(const std::string& sheet_id, const host::SavedStateStatus& status) {
  v1::SavedState state;
  state.set_name(state_name(sheet_id, status.id));
  state.set_tick(status.tick);
  state.set_scene_tick(status.scene_tick);
  state.set_num_vertices(status.num_vertices);
  state.set_num_bytes(status.num_bytes);
  state.set_state_hash(wire::encode_hash(status.state_hash));
  state.set_continuation_hash(wire::encode_hash(status.continuation_hash));
  state.set_saved_unix_us(status.saved_unix_us);
  return state;
}

// Returns the sheet and the state that a request names.
Result<StateName> addressed_state(const ApiCore& core, const std::string& name) {
  if (core.stopping) return server_stopping();
  return parse_state_name(name);
}

}  // namespace

void Api::save_state(const v1::SaveStateRequest& request, Reply<v1::SavedState> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  idempotent<v1::SavedState>(core_, "SaveState", request, std::move(reply), [&](const Reply<v1::SavedState>& answer) {
    core_->host.save_state(*id, request.state_id(), request.overwrite(),
                           [id = *id, answer](const Result<host::SavedStateStatus>& saved) {
                             if (!saved.ok()) return answer(with_field(saved.error(), "parent"));
                             answer(encode_state(id, *saved));
                           });
  });
}

void Api::restore_state(const v1::RestoreStateRequest& request, Reply<v1::Sheet> reply) {
  const Result<StateName> name = addressed_state(*core_, request.name());
  if (!name.ok()) return reply(name.error());
  idempotent<v1::Sheet>(core_, "RestoreState", request, std::move(reply), [&](Reply<v1::Sheet> answer) {
    core_->host.restore_state(name->sheet_id, name->state_id, sheet_reply(std::move(answer), "name"),
                              key_of("RestoreState", request).answered_by<host::SheetStatus>(encode_sheet));
  });
}

void Api::list_states(const v1::ListStatesRequest& request, Reply<v1::ListStatesResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.parent(), "parent");
  if (!id.ok()) return reply(id.error());
  core_->host.states(*id,
                     [id = *id, reply = std::move(reply)](const Result<std::vector<host::SavedStateStatus>>& states) {
                       if (!states.ok()) return reply(with_field(states.error(), "parent"));
                       v1::ListStatesResponse response;
                       for (const host::SavedStateStatus& status : *states)
                         *response.add_states() = encode_state(id, status);
                       reply(std::move(response));
                     });
}

void Api::delete_state(const v1::DeleteStateRequest& request, Reply<google::protobuf::Empty> reply) {
  const Result<StateName> name = addressed_state(*core_, request.name());
  if (!name.ok()) return reply(name.error());
  core_->host.delete_state(name->sheet_id, name->state_id, [reply = std::move(reply)](const Status& status) {
    if (!status.ok()) return reply(with_field(status.error(), "name"));
    reply(google::protobuf::Empty());
  });
}

}  // namespace kerf::api
