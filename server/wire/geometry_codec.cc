#include "server/wire/geometry_codec.h"

#include <utility>
#include <variant>

namespace kerf::wire {
namespace {

template <typename Points>
std::vector<Eigen::Vector2d> decode_points(const Points& points) {
  std::vector<Eigen::Vector2d> decoded;
  decoded.reserve(static_cast<std::size_t>(points.size()));
  for (const v1::Vec2& point : points) decoded.push_back(decode_vector(point));
  return decoded;
}

}  // namespace

Eigen::Vector2d decode_vector(const v1::Vec2& vector) {
  return {vector.x(), vector.y()};
}

Eigen::Vector3d decode_vector(const v1::Vec3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

void encode_vector(const Eigen::Vector2d& vector, v1::Vec2& message) {
  message.set_x(vector.x());
  message.set_y(vector.y());
}

void encode_vector(const Eigen::Vector3d& vector, v1::Vec3& message) {
  message.set_x(vector.x());
  message.set_y(vector.y());
  message.set_z(vector.z());
}

Result<cut::Curve> decode_curve(const v1::Curve& curve, const std::string& path) {
  switch (curve.kind_case()) {
    case v1::Curve::kBezier:
      return cut::Curve(cut::CubicBezier{decode_points(curve.bezier().points())});
    case v1::Curve::kPolyline:
      return cut::Curve(cut::Polyline{decode_points(curve.polyline().points())});
    case v1::Curve::kCircle:
      return cut::Curve(cut::Circle{decode_vector(curve.circle().center()), curve.circle().radius_m()});
    case v1::Curve::KIND_NOT_SET:
      break;
  }
  return choice_missing(path, "bezier, polyline or circle");
}

void encode_curve(const cut::Curve& curve, v1::Curve& message) {
  if (const auto* bezier = std::get_if<cut::CubicBezier>(&curve)) {
    for (const Eigen::Vector2d& point : bezier->points) encode_vector(point, *message.mutable_bezier()->add_points());
  } else if (const auto* polyline = std::get_if<cut::Polyline>(&curve)) {
    for (const Eigen::Vector2d& point : polyline->points) {
      encode_vector(point, *message.mutable_polyline()->add_points());
    }
  } else {
    const auto& circle = std::get<cut::Circle>(curve);
    encode_vector(circle.centre, *message.mutable_circle()->mutable_center());
    message.mutable_circle()->set_radius_m(circle.radius);
  }
}

Error missing(const std::string& path) {
  return invalid_argument("FIELD_MISSING", path + " must be given", path);
}

Error choice_missing(const std::string& path, const std::string& choices) {
  return invalid_argument("CHOICE_MISSING", path + " must be one of " + choices, path);
}

Error unknown_enum(const std::string& path, int value) {
  return invalid_argument("UNKNOWN_ENUM_VALUE", path + " is " + std::to_string(value) + ", which has no meaning", path);
}

Error within(const std::string& prefix, Error error) {
  error.field = error.field.empty() ? prefix : prefix + "." + error.field;
  return error;
}

}  // namespace kerf::wire
