#include "server/api/picture.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "render/image.h"

namespace kerf::api {
namespace {

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

render::Vec3 to_vec3(const v1::Vec3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}
render::Vec3 to_vec3(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Result<render::Camera> decode_camera(const v1::Camera& message) {
  render::Camera camera;
  camera.eye = to_vec3(message.eye());
  camera.target = to_vec3(message.target());
  if (message.has_up()) camera.up = to_vec3(message.up());
  if (message.vertical_fov_deg() != 0.0) camera.vertical_fov = message.vertical_fov_deg();
  const render::Status status = render::validate(camera);
  if (status.ok()) return camera;
  Error error = to_error(status);
  if (error.field == "camera.vertical_fov") error.field = "camera.vertical_fov_deg";
  return error;
}

Status check_range(int value, int low, int high, const std::string& field) {
  if (value >= low && value <= high) return Nothing{};
  return invalid_argument(
      "OUT_OF_RANGE",
      field + " is " + std::to_string(value) + "; must be " + std::to_string(low) + " to " + std::to_string(high),
      field);
}

struct ShapeForRenderer {
  render::Collider operator()(const contact::Plane& plane) const {
    return render::Plane{to_vec3(plane.point), to_vec3(plane.normal)};
  }
  render::Collider operator()(const contact::Sphere& sphere) const {
    return render::Sphere{to_vec3(sphere.centre), sphere.radius};
  }
  render::Collider operator()(const contact::OrientedBox& box) const {
    render::Box drawn{to_vec3(box.centre), to_vec3(box.half_extents), {1.0, 0.0, 0.0, 0.0}};
    const double length = box.axis.norm();
    if (length > 0.0) {
      const Eigen::Vector3d axis = box.axis / length;
      const double sine = std::sin(0.5 * box.angle);
      drawn.rotation = {std::cos(0.5 * box.angle), sine * axis.x(), sine * axis.y(), sine * axis.z()};
    }
    return drawn;
  }
  render::Collider operator()(const contact::Capsule& capsule) const {
    return render::Capsule{to_vec3(capsule.a), to_vec3(capsule.b), capsule.radius};
  }
};

// The arrays that render::Mesh views.
struct MeshArrays {
  std::vector<float> positions;
  std::vector<float> material;
  std::vector<std::int32_t> triangles;
  std::vector<std::int32_t> pieces;
};

// Material points in the plane z = 0.
Eigen::Matrix3Xd laid_out(const Eigen::Matrix2Xd& material) {
  Eigen::Matrix3Xd positions = Eigen::Matrix3Xd::Zero(3, material.cols());
  positions.topRows<2>() = material;
  return positions;
}

MeshArrays arrays_of(const sheet::Snapshot& snapshot, const Eigen::Matrix3Xd& positions) {
  const sheet::Topology& topology = *snapshot.topology;
  MeshArrays arrays;
  const auto append = [](const auto& matrix, std::vector<float>& out) {
    out.reserve(static_cast<std::size_t>(matrix.size()));
    for (Eigen::Index i = 0; i < matrix.size(); ++i) out.push_back(static_cast<float>(matrix.data()[i]));
  };
  append(positions, arrays.positions);
  append(topology.material_positions, arrays.material);
  for (std::size_t slot = 0; slot < topology.triangles.size(); ++slot) {
    if (topology.pieces[slot] == mesh::kNone) continue;
    arrays.triangles.insert(arrays.triangles.end(), topology.triangles[slot].begin(), topology.triangles[slot].end());
    arrays.pieces.push_back(topology.pieces[slot]);
  }
  return arrays;
}

render::Style style_of(const PictureRequest& request) {
  render::Style style;
  style.wireframe = request.wireframe;
  style.shadows = !request.undeformed;            // a flat sheet throws none on itself
  if (request.undeformed && request.wireframe) {  // the triangles are what is looked at
    style.texture = false;
    style.front = {0.66, 0.76, 0.86};
  }
  return style;
}

render::Camera whole_sheet(std::span<const float> positions, const PictureRequest& request) {
  const double aspect = static_cast<double>(request.width) / request.height;
  if (!request.undeformed) return render::fit_camera(positions, aspect);
  return render::fit_camera(positions, aspect, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0});
}

// No fault of the request: a sheet that nothing holds falls on for ever.
Error out_of_reach(const Eigen::Matrix3Xd& positions) {
  std::array<char, 160> text{};
  std::snprintf(
      text.data(), text.size(),
      "the sheet reaches to %.3g m from the origin; pictures are drawn within %.3g m of it: reset the sheet, and "
      "pin it or put something under it",
      positions.cwiseAbs().maxCoeff(), render::kMaxCoordinate);
  return {ErrorCode::kFailedPrecondition, "SHEET_OUT_OF_REACH", text.data(), {}};
}

Result<v1::RenderImageResponse> encode(const render::Pixels& pixels, const PictureRequest& request) {
  std::vector<std::uint8_t> bytes;
  const render::Status status =
      request.jpeg ? render::encode_jpeg(pixels, request.jpeg_quality, bytes) : render::encode_png(pixels, bytes);
  if (!status.ok()) return to_error(status);
  v1::RenderImageResponse response;
  response.set_image(bytes.data(), bytes.size());
  response.set_media_type(request.jpeg ? "image/jpeg" : "image/png");
  response.set_width_px(pixels.width);
  response.set_height_px(pixels.height);
  return response;
}

}  // namespace

Result<PictureRequest> decode_picture_request(const v1::RenderImageRequest& message) {
  PictureRequest request;
  if (message.width_px() != 0) request.width = message.width_px();
  if (message.height_px() != 0) request.height = message.height_px();
  if (message.jpeg_quality() != 0) request.jpeg_quality = message.jpeg_quality();
  request.wireframe = message.wireframe();
  request.undeformed = message.undeformed();
  if (Status s = check_range(request.width, render::kMinImageSize, render::kMaxImageSize, "width_px"); !s.ok()) {
    return s.error();
  }
  if (Status s = check_range(request.height, render::kMinImageSize, render::kMaxImageSize, "height_px"); !s.ok()) {
    return s.error();
  }
  if (Status s = check_range(request.jpeg_quality, 1, 100, "jpeg_quality"); !s.ok()) return s.error();
  switch (message.format()) {
    case v1::RenderImageRequest::FORMAT_UNSPECIFIED:
    case v1::RenderImageRequest::PNG:
      break;
    case v1::RenderImageRequest::JPEG:
      request.jpeg = true;
      break;
    default:
      return invalid_argument("UNKNOWN_ENUM_VALUE", "format must be PNG or JPEG", "format");
  }
  if (message.has_camera()) {
    Result<render::Camera> camera = decode_camera(message.camera());
    if (!camera.ok()) return camera.error();
    request.camera = *camera;
  }
  return request;
}

PictureSubject picture_subject(const sheet::Sheet& sheet) {
  return {sheet.snapshot(), sheet.shared_config(), sheet.mesh().bounding_box()};
}

Result<v1::RenderImageResponse> draw_picture(render::Renderer& renderer, const PictureSubject& subject,
                                             const PictureRequest& request) {
  const sheet::Snapshot& snapshot = *subject.snapshot;
  const Eigen::Matrix3Xd positions =
      request.undeformed ? laid_out(snapshot.topology->material_positions) : snapshot.positions;
  if (!(positions.array().abs() <= render::kMaxCoordinate).all()) return out_of_reach(positions);
  const MeshArrays arrays = arrays_of(snapshot, positions);
  render::Scene scene;
  scene.mesh.positions = arrays.positions;
  scene.mesh.material_coordinates = arrays.material;
  scene.mesh.triangles = arrays.triangles;
  scene.mesh.piece_ids = arrays.pieces;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    scene.mesh.material_lower[axis] = static_cast<float>(subject.material_box.min()[i]);
    scene.mesh.material_upper[axis] = static_cast<float>(subject.material_box.max()[i]);
  }
  if (!request.undeformed) {
    for (const contact::Collider& collider : subject.config->colliders) {
      scene.colliders.push_back(std::visit(ShapeForRenderer{}, collider.shape));
    }
  }
  scene.style = style_of(request);
  const render::Camera camera = request.camera ? *request.camera : whole_sheet(scene.mesh.positions, request);
  if (!request.camera && !render::validate(camera).ok()) return out_of_reach(positions);
  render::Pixels pixels;
  const render::Status status = renderer.render(scene, camera, request.width, request.height, pixels);
  if (!status.ok()) return to_error(status);
  Result<v1::RenderImageResponse> response = encode(pixels, request);
  if (response.ok()) response->set_tick(subject.snapshot->tick);
  return response;
}

}  // namespace kerf::api
