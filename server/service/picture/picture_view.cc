#include "server/service/picture/picture_view.h"

namespace kerf::picture {
namespace {

constexpr int kDefaultJpegQuality = 85;

render::Vec3 to_vec3(const v1::Vec3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

void encode_vec3(const render::Vec3& vector, v1::Vec3& message) {
  message.set_x(vector.x);
  message.set_y(vector.y);
  message.set_z(vector.z);
}

Result<render::Camera> decode_camera(const v1::Camera& message, const std::string& prefix) {
  render::Camera camera;
  camera.eye = to_vec3(message.eye());
  camera.target = to_vec3(message.target());
  if (message.has_up()) camera.up = to_vec3(message.up());
  if (message.vertical_fov_deg() != 0.0) camera.vertical_fov = message.vertical_fov_deg();
  const render::Status status = render::validate(camera);
  if (status.ok()) return camera;
  Error error = to_error(status);
  if (error.field == "camera.vertical_fov") error.field = "camera.vertical_fov_deg";
  error.field = prefix + error.field;
  return error;
}

Result<v1::ColorBy> decode_color_by(v1::ColorBy color_by, const std::string& field) {
  switch (color_by) {
    case v1::COLOR_BY_UNSPECIFIED:
      return v1::SIDES;
    case v1::SIDES:
    case v1::PIECES:
    case v1::STRAINS:
      return color_by;
    default:
      return invalid_argument(
          "UNKNOWN_ENUM_VALUE",
          field + " is " + std::to_string(color_by) + "; must be SIDES (1), PIECES (2) or STRAINS (3), or 0 for SIDES",
          field);
  }
}

// Decodes the fields that both messages have under the same names.
template <typename Message>
Result<PictureView> decode_common(const Message& message, const std::string& prefix) {
  PictureView view;
  if (message.width_px() != 0) view.width = message.width_px();
  if (message.height_px() != 0) view.height = message.height_px();
  view.wireframe = message.wireframe();
  view.undeformed = message.undeformed();
  view.dark = message.dark();
  Status size = check_range(view.width, render::kMinImageSize, render::kMaxImageSize, prefix + "width_px");
  if (size.ok()) size = check_range(view.height, render::kMinImageSize, render::kMaxImageSize, prefix + "height_px");
  KERF_TRY(size);
  KERF_TRY_ASSIGN(view.color_by, decode_color_by(message.color_by(), prefix + "color_by"));
  if (message.has_camera()) {
    KERF_TRY_ASSIGN(view.camera, decode_camera(message.camera(), prefix));
  }
  return view;
}

}  // namespace

Result<PictureView> decode_view(const v1::RenderImageRequest& message) {
  return decode_common(message, "");
}

Result<PictureView> decode_view(const v1::ImageView& message, const std::string& prefix) {
  return decode_common(message, prefix);
}

Result<StillFormat> decode_format(const v1::RenderImageRequest& message) {
  StillFormat format;
  format.quality = message.jpeg_quality() != 0 ? message.jpeg_quality() : kDefaultJpegQuality;
  KERF_TRY(check_range(format.quality, 1, 100, "jpeg_quality"));
  switch (message.format()) {
    case v1::RenderImageRequest::FORMAT_UNSPECIFIED:
    case v1::RenderImageRequest::PNG:
      return format;
    case v1::RenderImageRequest::JPEG:
      format.jpeg = true;
      return format;
    default:
      return invalid_argument("UNKNOWN_ENUM_VALUE", "format must be PNG or JPEG", "format");
  }
}

Status check_range(int value, int low, int high, const std::string& field) {
  if (value >= low && value <= high) return Nothing{};
  return invalid_argument(
      "OUT_OF_RANGE",
      field + " is " + std::to_string(value) + "; must be " + std::to_string(low) + " to " + std::to_string(high),
      field);
}

v1::Camera encode_camera(const render::Camera& camera) {
  v1::Camera message;
  encode_vec3(camera.eye, *message.mutable_eye());
  encode_vec3(camera.target, *message.mutable_target());
  encode_vec3(camera.up, *message.mutable_up());
  message.set_vertical_fov_deg(camera.vertical_fov);
  return message;
}

Error to_error(const render::Status& status) {
  ErrorCode code = ErrorCode::kInternal;
  switch (status.code) {
    case render::StatusCode::kOk:
    case render::StatusCode::kInternal:
      break;
    case render::StatusCode::kInvalidArgument:
      code = ErrorCode::kInvalidArgument;
      break;
    case render::StatusCode::kResourceExhausted:
      code = ErrorCode::kResourceExhausted;
      break;
    case render::StatusCode::kUnavailable:
      code = ErrorCode::kUnavailable;
      break;
  }
  return {code, status.reason, status.message, status.field};
}

}  // namespace kerf::picture
