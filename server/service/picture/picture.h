#pragma once

#include <memory>
#include <string>

#include "render/image.h"
#include "render/renderer.h"
#include "server/base/result.h"
#include "server/core/sheet/sheet.h"
#include "server/service/picture/picture_view.h"

// Draws a sheet and encodes the picture.
namespace kerf::api {

// Holds the parts of a sheet that never change.
struct Backdrop {
  std::shared_ptr<const sheet::SheetConfig> config;  // For the colliders.
  Eigen::AlignedBox2d material_box;                  // m, of the sheet as built.
};
Backdrop backdrop_of(const sheet::Sheet& sheet);

// Holds the parts of a sheet that are drawn.
struct PictureSubject {
  std::shared_ptr<const sheet::Snapshot> snapshot;  // A view coloured by strains is dark if it has none.
  Backdrop backdrop;
};

struct DrawnPicture {
  render::Pixels pixels;
  render::Camera camera;    // The view's, or the one chosen.
  double strain_end = 0.0;  // End of the scale if the view is coloured by strains.
};

// Draws a picture; blocks until it is done. `strain_end`: that of the picture before, so that the scale does not change
// with each; 0: none. Errors of render::Renderer::render(); kFailedPrecondition SHEET_OUT_OF_REACH.
Result<DrawnPicture> draw_picture(render::Renderer& renderer, const PictureSubject& subject, const PictureView& view,
                                  double strain_end = 0.0);

// Encodes a still picture. Errors of the image encoders.
Result<std::string> encode_still(const render::Pixels& pixels, const StillFormat& format);

}  // namespace kerf::api
