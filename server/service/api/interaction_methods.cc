#include "kerf/v1/interaction.pb.h"
#include "server/service/api/core.h"
#include "server/service/wire/command_codec.h"

// Implements InteractionService.
namespace kerf::api {
namespace {

// Implements every method here: checks the name, submits the decoded command, replies with the tick.
void submit(const std::shared_ptr<ApiCore>& core, const std::string& name, Result<scene::Command> command,
            Reply<v1::InteractionResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core, name, "name");
  if (!id.ok()) return reply(id.error());
  if (!command.ok()) return reply(command.error());
  core->host.submit(*id, std::move(*command), [reply = std::move(reply)](Result<host::CommandResult> result) {
    if (!result.ok()) return reply(with_field(result.error(), "name"));
    v1::InteractionResponse response;
    response.set_tick(result->reply.tick);
    reply(std::move(response));
  });
}

Error missing(const char* field) {
  return invalid_argument("FIELD_MISSING", std::string(field) + " must be given", field);
}

}  // namespace

void Api::grab_point(const v1::GrabPointRequest& request, Reply<v1::InteractionResponse> reply) {
  submit(core_, request.name(), request.has_grab() ? wire::decode_grab(request.grab()) : missing("grab"),
         std::move(reply));
}

void Api::drag_point(const v1::DragPointRequest& request, Reply<v1::InteractionResponse> reply) {
  submit(core_, request.name(), request.has_drag() ? wire::decode_drag(request.drag()) : missing("drag"),
         std::move(reply));
}

void Api::release_point(const v1::ReleasePointRequest& request, Reply<v1::InteractionResponse> reply) {
  submit(core_, request.name(), request.has_release() ? wire::decode_release(request.release()) : missing("release"),
         std::move(reply));
}

void Api::set_sheet_pins(const v1::SetSheetPinsRequest& request, Reply<v1::InteractionResponse> reply) {
  submit(core_, request.name(),
         request.has_set_pins() ? wire::decode_set_pins(request.set_pins()) : missing("set_pins"), std::move(reply));
}

void Api::set_sheet_gravity(const v1::SetSheetGravityRequest& request, Reply<v1::InteractionResponse> reply) {
  submit(core_, request.name(),
         request.has_set_gravity() ? wire::decode_set_gravity(request.set_gravity()) : missing("set_gravity"),
         std::move(reply));
}

void Api::set_sheet_wind(const v1::SetSheetWindRequest& request, Reply<v1::InteractionResponse> reply) {
  submit(core_, request.name(),
         request.has_set_wind() ? wire::decode_set_wind(request.set_wind()) : missing("set_wind"), std::move(reply));
}

void Api::set_sheet_material(const v1::SetSheetMaterialRequest& request, Reply<v1::InteractionResponse> reply) {
  submit(core_, request.name(),
         request.has_set_material() ? wire::decode_set_material(request.set_material()) : missing("set_material"),
         std::move(reply));
}

void Api::set_sheet_self_contact(const v1::SetSheetSelfContactRequest& request, Reply<v1::InteractionResponse> reply) {
  submit(core_, request.name(),
         request.has_set_self_contact() ? wire::decode_set_self_contact(request.set_self_contact())
                                        : missing("set_self_contact"),
         std::move(reply));
}

}  // namespace kerf::api
