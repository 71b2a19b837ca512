#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "kerf/v1/render.pb.h"
#include "render/renderer.h"
#include "server/base/result.h"
#include "server/sheet/sheet.h"

// RenderImage between the message and the renderer.
namespace kerf::api {

// A valid request with its defaults filled in.
struct PictureRequest {
  int width = 640;                       // pixels
  int height = 360;                      // pixels
  std::optional<render::Camera> camera;  // empty: chosen to show the whole sheet
  bool wireframe = false;
  bool undeformed = false;
  bool jpeg = false;
  int jpeg_quality = 85;
};

// kInvalidArgument with the field of RenderImageRequest.
Result<PictureRequest> decode_picture_request(const v1::RenderImageRequest& request);

// What of a sheet is drawn, taken between two ticks.
struct PictureSubject {
  std::shared_ptr<const sheet::Snapshot> snapshot;
  std::shared_ptr<const sheet::SheetConfig> config;  // for the colliders
  Eigen::AlignedBox2d material_box;                  // m, of the sheet as built
};
PictureSubject picture_subject(const sheet::Sheet& sheet);

// Draws and encodes; blocks until it is done. Errors of render::Renderer::render() and the image encoders.
Result<v1::RenderImageResponse> draw_picture(render::Renderer& renderer, const PictureSubject& subject,
                                             const PictureRequest& request);

}  // namespace kerf::api
