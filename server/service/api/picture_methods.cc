#include "kerf/v1/render.pb.h"
#include "server/service/api/core.h"
#include "server/service/api/image_session.h"
#include "server/service/picture/picture.h"

// Implements RenderService.
namespace kerf::api {
namespace {

struct PictureRequest {
  picture::PictureView view;
  picture::StillFormat format;
};

Result<PictureRequest> decode_request(const v1::RenderImageRequest& message) {
  KERF_TRY_ASSIGN(const picture::PictureView view, picture::decode_view(message));
  KERF_TRY_ASSIGN(const picture::StillFormat format, picture::decode_format(message));
  return PictureRequest{view, format};
}

Result<v1::RenderImageResponse> make_picture(ApiCore& core, const picture::PictureSubject& subject,
                                             const PictureRequest& request) {
  KERF_TRY_ASSIGN(const picture::DrawnPicture picture, picture::draw_picture(*core.renderer, subject, request.view));
  ++core.pictures.rendered;
  KERF_TRY_ASSIGN(std::string image, picture::encode_still(picture.pixels, request.format));
  ++core.pictures.encoded;
  v1::RenderImageResponse response;
  response.set_image(std::move(image));
  response.set_media_type(request.format.jpeg ? "image/jpeg" : "image/png");
  response.set_tick(subject.snapshot->tick);
  response.set_width_px(request.view.width);
  response.set_height_px(request.view.height);
  response.set_strain_end(picture.strain_end);
  return response;
}

}  // namespace

Status check_renderer(const ApiCore& core) {
  if (core.renderer != nullptr && core.renderer->available()) return Nothing{};
  const std::string why = core.renderer != nullptr ? core.renderer->description() : "none: none was started";
  return unavailable("RENDERER_UNAVAILABLE", "this server draws no pictures (" + why + ")");
}

void Api::render_image(const v1::RenderImageRequest& request, Reply<v1::RenderImageResponse> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  const Result<PictureRequest> wanted = decode_request(request);
  if (!wanted.ok()) return reply(wanted.error());
  if (const Status status = check_renderer(*core_); !status.ok()) return reply(status.error());
  const bool with_strains = wanted->view.color_by == v1::STRAINS;
  inspect<picture::PictureSubject>(
      core_, *id,
      [with_strains](const sheet::Sheet& sheet) {
        return picture::PictureSubject{sheet.snapshot({}, with_strains), picture::backdrop_of(sheet)};
      },
      "name",
      [core = core_, wanted = *wanted, reply = std::move(reply)](Result<picture::PictureSubject> subject) {
        if (!subject.ok()) return reply(subject.error());
        in_background<v1::RenderImageResponse>(
            core->picture_worker, reply,
            [core, wanted, drawn = std::move(*subject)] { return make_picture(*core, drawn, wanted); },
            too_many_pictures(*core));
      });
}

std::shared_ptr<ImageSession> Api::watch_images(const Result<auth::Caller>& caller) {
  return make_image_session(core_, caller);
}

std::shared_ptr<ImageSession> Api::play_images(const v1::WatchImagesStart& start, const Result<auth::Caller>& caller) {
  return make_image_player(core_, caller, start);
}

PictureCounts Api::picture_counts() const {
  const picture::PictureCounters& counters = core_->pictures;
  return {counters.rendered, counters.encoded, counters.shared,
          counters.sent,     counters.skipped, core_->num_image_streams};
}

}  // namespace kerf::api
