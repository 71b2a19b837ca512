#pragma once

#include <optional>
#include <string>

#include "kerf/v1/render.pb.h"
#include "render/renderer.h"
#include "server/base/result.h"

// Converts between the messages of RenderImage and WatchImages and the renderer's types.
namespace kerf::picture {

// Describes a view of a sheet. Equal views of one sheet give the same picture.
struct PictureView {
  int width = 640;                       // pixels, kMinImageSize..kMaxImageSize
  int height = 360;                      // pixels, kMinImageSize..kMaxImageSize
  std::optional<render::Camera> camera;  // Empty: chosen to show the whole sheet.
  bool wireframe = false;
  bool undeformed = false;
  bool dark = false;                 // Dark backdrop.
  v1::ColorBy color_by = v1::SIDES;  // Never unspecified.

  friend bool operator==(const PictureView&, const PictureView&) = default;
};

// Describes the file format of a single picture.
struct StillFormat {
  bool jpeg = false;  // Otherwise PNG.
  int quality = 0;    // JPEG quality, 1..100.

  friend bool operator==(const StillFormat&, const StillFormat&) = default;
};

// Decode with defaults filled in. kInvalidArgument with the field of the message, after `prefix` ("start.view.", or
// nothing).
Result<PictureView> decode_view(const v1::RenderImageRequest& message);
Result<PictureView> decode_view(const v1::ImageView& message, const std::string& prefix);
Result<StillFormat> decode_format(const v1::RenderImageRequest& message);

// Checks low <= value <= high. kInvalidArgument OUT_OF_RANGE with the limits.
Status check_range(int value, int low, int high, const std::string& field);

v1::Camera encode_camera(const render::Camera& camera);

// Converts errors of the renderer and the encoders.
Error to_error(const render::Status& status);

}  // namespace kerf::picture
