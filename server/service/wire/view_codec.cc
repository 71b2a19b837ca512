#include "server/service/wire/view_codec.h"

#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Geometry>

#include "server/base/elementary.h"
#include "server/service/wire/geometry_codec.h"

namespace kerf::wire {
namespace {

constexpr double kDefaultFovDeg = 40.0;
constexpr double kLeastAngle = 1.0e-3;  // rad; smallest angle between the view direction and up.

// Clip planes that only keep the matrix regular, since depths are not taken from the clip space.
constexpr double kNear = 0.01;  // m
constexpr double kFar = 1.0e4;  // m

Result<Eigen::Matrix4d> decode_matrix(const google::protobuf::RepeatedField<double>& numbers, const std::string& path) {
  if (numbers.size() != 16) {
    return invalid_argument(
        "MATRIX_SIZE", path + " has " + std::to_string(numbers.size()) + " numbers; a matrix has 16, column by column",
        path);
  }
  return Eigen::Matrix4d(Eigen::Map<const Eigen::Matrix4d>(numbers.data()));
}

Status decode_camera(const v1::Camera& camera, const std::string& path, cut::View& view) {
  const Eigen::Vector3d eye = decode_vector(camera.eye());
  const Eigen::Vector3d up = camera.has_up() ? decode_vector(camera.up()) : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d towards = decode_vector(camera.target()) - eye;
  const double fov = camera.vertical_fov_deg() == 0.0 ? kDefaultFovDeg : camera.vertical_fov_deg();
  if (!(fov >= 1.0 && fov <= 179.0)) {
    return invalid_argument("FOV_OUT_OF_RANGE", "vertical_fov_deg must be 1..179", path + ".vertical_fov_deg");
  }
  const double sine_between = towards.cross(up).norm() / (towards.norm() * up.norm());
  if (!(sine_between > kLeastAngle)) {
    return invalid_argument("CAMERA_SINGULAR", "eye and target must differ, and up must not point along the view",
                            path + ".up");
  }
  const Eigen::Vector3d back = -towards.normalized();
  const Eigen::Vector3d right = up.cross(back).normalized();
  view.view.setIdentity();
  view.view.row(0).head<3>() = right;
  view.view.row(1).head<3>() = back.cross(right);
  view.view.row(2).head<3>() = back;
  view.view.block<3, 1>(0, 3) = -(view.view.block<3, 3>(0, 0) * eye);
  const double half_view = 0.5 * fov * std::numbers::pi / 180.0;  // rad
  const double f = cosine(half_view) / sine(half_view);
  view.projection.setZero();
  view.projection(0, 0) = f * view.height_px / view.width_px;
  view.projection(1, 1) = f;
  view.projection(2, 2) = (kFar + kNear) / (kNear - kFar);
  view.projection(2, 3) = 2.0 * kFar * kNear / (kNear - kFar);
  view.projection(3, 2) = -1.0;
  return Nothing{};
}

Result<cut::LayerRule> decode_layers(v1::View::Layers layers, const std::string& path) {
  switch (layers) {
    case v1::View::LAYERS_UNSPECIFIED:
    case v1::View::NEAREST:
      return cut::LayerRule::kNearest;
    case v1::View::ALL:
      return cut::LayerRule::kAll;
    case v1::View::ONE_PIECE:
      return cut::LayerRule::kPiece;
    case v1::View::DEPTH_RANGE:
      return cut::LayerRule::kDepthRange;
    default:
      return unknown_enum(path, layers);
  }
}

v1::View::Layers encode_layers(cut::LayerRule layers) {
  switch (layers) {
    case cut::LayerRule::kNearest:
      return v1::View::NEAREST;
    case cut::LayerRule::kAll:
      return v1::View::ALL;
    case cut::LayerRule::kPiece:
      return v1::View::ONE_PIECE;
    case cut::LayerRule::kDepthRange:
      return v1::View::DEPTH_RANGE;
  }
  return v1::View::LAYERS_UNSPECIFIED;
}

}  // namespace

Result<cut::View> decode_view(const v1::View& message, const std::string& path) {
  cut::View view;
  view.width_px = message.width_px();
  view.height_px = message.height_px();
  const bool has_matrices = message.view_size() > 0 || message.projection_size() > 0;
  if (!message.has_camera() && !has_matrices) return missing(path + ".camera");
  if (message.has_camera() && has_matrices) {
    return invalid_argument("CHOICE_MISSING", "give a camera or two matrices, not both", path + ".camera");
  }
  if (message.has_camera()) {
    KERF_TRY(decode_camera(message.camera(), path + ".camera", view));
  } else {
    KERF_TRY_ASSIGN(const Eigen::Matrix4d world_to_camera, decode_matrix(message.view(), path + ".view"));
    KERF_TRY_ASSIGN(const Eigen::Matrix4d projection, decode_matrix(message.projection(), path + ".projection"));
    view.view = world_to_camera;
    view.projection = projection;
  }
  KERF_TRY_ASSIGN(view.layers, decode_layers(message.layers(), path + ".layers"));
  if (message.has_piece()) view.piece = message.piece();
  view.nearest_m = message.nearest_m();
  view.farthest_m = message.farthest_m();
  return view;
}

void encode_view(const cut::View& view, v1::View& message) {
  message.mutable_view()->Assign(view.view.data(), view.view.data() + view.view.size());
  message.mutable_projection()->Assign(view.projection.data(), view.projection.data() + view.projection.size());
  message.set_width_px(view.width_px);
  message.set_height_px(view.height_px);
  message.set_layers(encode_layers(view.layers));
  if (view.piece != mesh::kNone) message.set_piece(view.piece);
  message.set_nearest_m(view.nearest_m);
  message.set_farthest_m(view.farthest_m);
}

}  // namespace kerf::wire
