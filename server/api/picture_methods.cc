#include "kerf/v1/render.pb.h"
#include "server/api/core.h"
#include "server/api/picture.h"

// RenderService.
namespace kerf::api {
namespace {

Status check_renderer(const ApiCore& core) {
  if (core.renderer != nullptr && core.renderer->available()) return Nothing{};
  const std::string why = core.renderer != nullptr ? core.renderer->description() : "none: none was started";
  return Error{ErrorCode::kUnavailable, "RENDERER_UNAVAILABLE", "this server draws no pictures (" + why + ")", {}};
}

}  // namespace

void Api::render_image(const v1::RenderImageRequest& request, Reply<v1::RenderImageResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  const Result<PictureRequest> wanted = decode_picture_request(request);
  if (!wanted.ok()) return reply(wanted.error());
  if (const Status status = check_renderer(*core_); !status.ok()) return reply(status.error());
  look_at<PictureSubject>(
      core_, *id, picture_subject, "name",
      [core = core_, wanted = *wanted, reply = std::move(reply)](Result<PictureSubject> subject) {
        if (!subject.ok()) return reply(subject.error());
        in_background(
            core->worker, reply,
            [core, wanted, reply, drawn = std::move(*subject)] { reply(draw_picture(*core->renderer, drawn, wanted)); },
            too_many_pictures(*core));
      });
}

}  // namespace kerf::api
