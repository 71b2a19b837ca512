#pragma once

#include <optional>
#include <string>

#include "kerf/v1/render.pb.h"
#include "render/renderer.h"
#include "server/base/result.h"

// What RenderImage and WatchImages ask for, between their messages and the renderer.
namespace kerf::api {

// How a sheet is looked at. Equal views of one sheet are one picture.
struct PictureView {
  int width = 640;                       // pixels, kMinImageSize..kMaxImageSize
  int height = 360;                      // pixels, likewise
  std::optional<render::Camera> camera;  // empty: chosen to show the whole sheet
  bool wireframe = false;
  bool undeformed = false;
  bool dark = false;                 // the backdrop
  v1::ColorBy color_by = v1::SIDES;  // never unspecified

  friend bool operator==(const PictureView&, const PictureView&) = default;
};

// How a picture is written by itself.
struct StillFormat {
  bool jpeg = false;  // else PNG
  int quality = 0;    // of JPEG, 1..100

  friend bool operator==(const StillFormat&, const StillFormat&) = default;
};

// With defaults filled in; kInvalidArgument with the field of the message, after `prefix` ("start.view.", or nothing).
Result<PictureView> decode_view(const v1::RenderImageRequest& message);
Result<PictureView> decode_view(const v1::ImageView& message, const std::string& prefix);
Result<StillFormat> decode_format(const v1::RenderImageRequest& message);

// kInvalidArgument OUT_OF_RANGE with the limits.
Status check_range(int value, int low, int high, const std::string& field);

v1::Camera encode_camera(const render::Camera& camera);

// The renderer's and the encoders' refusals.
Error to_error(const render::Status& status);

}  // namespace kerf::api
