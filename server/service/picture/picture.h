#pragma once

#include <memory>
#include <string>

#include "render/image.h"
#include "render/renderer.h"
#include "server/base/result.h"
#include "server/core/sheet/sheet.h"
#include "server/service/picture/picture_view.h"

// Draws a sheet and encodes the picture.
namespace kerf::picture {

// Holds data of a sheet that its pictures need and that never change.
struct Backdrop {
  std::shared_ptr<const scene::SheetConfig> config;  // For the colliders.
  Eigen::AlignedBox2d material_box;                  // m, bounds of the material coordinates as built.
};
Backdrop backdrop_of(const sheet::Sheet& sheet);

// Holds the parts of a sheet that are drawn.
struct PictureSubject {
  std::shared_ptr<const sheet::Snapshot> snapshot;  // Without strains, a view coloured by them is dark.
  Backdrop backdrop;
};

struct DrawnPicture {
  render::Pixels pixels;
  render::Camera camera;    // The view's camera, or the one chosen to show the whole sheet.
  double strain_end = 0.0;  // Strain at the end of the colour scale; 0 if strains give no colours.
};

// Draws a picture; blocks until it is done. `strain_end`: that of the picture before, so that the colour scale does not
// change with every picture; 0: there is none. Errors of render::Renderer::render(); kFailedPrecondition
// SHEET_OUT_OF_REACH.
Result<DrawnPicture> draw_picture(render::Renderer& renderer, const PictureSubject& subject, const PictureView& view,
                                  double strain_end = 0.0);

// Encodes a still picture. Errors of the image encoders.
Result<std::string> encode_still(const render::Pixels& pixels, const StillFormat& format);

}  // namespace kerf::picture
