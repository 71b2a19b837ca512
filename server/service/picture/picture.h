#pragma once

#include <memory>
#include <string>

#include "render/image.h"
#include "render/renderer.h"
#include "server/base/result.h"
#include "server/core/sheet/sheet.h"
#include "server/service/picture/picture_view.h"

// From a sheet to the bytes of a picture.
namespace kerf::api {

// What of a sheet stays the same as long as it lives.
struct Backdrop {
  std::shared_ptr<const sheet::SheetConfig> config;  // for the colliders
  Eigen::AlignedBox2d material_box;                  // m, of the sheet as built
};
Backdrop backdrop_of(const sheet::Sheet& sheet);

// What of a sheet is drawn.
struct PictureSubject {
  std::shared_ptr<const sheet::Snapshot> snapshot;  // a view coloured by strains is dark where it has none
  Backdrop backdrop;
};

struct DrawnPicture {
  render::Pixels pixels;
  render::Camera camera;    // the view's, or the one that was chosen
  double strain_end = 0.0;  // of the scale, where the view is coloured by strains
};

// Blocks until the picture is drawn. `strain_end`: of the picture before, so that the scale does not change with each;
// 0: there was none. Errors of render::Renderer::render(); kFailedPrecondition SHEET_OUT_OF_REACH.
Result<DrawnPicture> draw_picture(render::Renderer& renderer, const PictureSubject& subject, const PictureView& view,
                                  double strain_end = 0.0);

// Errors of the image encoders.
Result<std::string> encode_still(const render::Pixels& pixels, const StillFormat& format);

}  // namespace kerf::api
