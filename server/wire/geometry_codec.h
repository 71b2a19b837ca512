#pragma once

#include <string>

#include <Eigen/Core>

#include "kerf/v1/geometry.pb.h"
#include "server/base/result.h"
#include "server/sheet/command.h"

// kerf.v1 vectors and curves, and the errors that all decoders share.
namespace kerf::wire {

Eigen::Vector2d decode_vector(const v1::Vec2& vector);
Eigen::Vector3d decode_vector(const v1::Vec3& vector);
void encode_vector(const Eigen::Vector2d& vector, v1::Vec2& message);
void encode_vector(const Eigen::Vector3d& vector, v1::Vec3& message);

// Unchecked, but that a kind is chosen: CHOICE_MISSING, field `path`.
Result<cut::Curve> decode_curve(const v1::Curve& curve, const std::string& path);
void encode_curve(const cut::Curve& curve, v1::Curve& message);

// kInvalidArgument FIELD_MISSING: a message that has no default.
Error missing(const std::string& path);
// kInvalidArgument CHOICE_MISSING: a oneof without a member. `choices`: for people, "bezier, polyline or circle".
Error choice_missing(const std::string& path, const std::string& choices);
// kInvalidArgument UNKNOWN_ENUM_VALUE.
Error unknown_enum(const std::string& path, int value);
// The error of a part, as one of the whole.
Error within(const std::string& prefix, Error error);

}  // namespace kerf::wire
