#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/mesh/ids.h"

// Checks of single request fields. Errors are kInvalidArgument NOT_FINITE, OUT_OF_RANGE, TOO_MANY (for counts) or as
// said below. Messages have the field, the number and the limit.
namespace kerf::scene {

// Returns the name of an element of a list in errors, such as "pins[2]".
std::string indexed(const std::string& field, std::size_t index);

Status check_number(double value, double low, double high, const std::string& field);
Status check_integer(std::int64_t value, std::int64_t low, std::int64_t high, const std::string& field);
// Checks the length of a list or text. `unit`: what is counted, for the message, such as "bytes" or "pin regions".
Status check_count(std::size_t count, std::size_t limit, const std::string& unit, const std::string& field);
// Check that each component is finite and at most `limit` in magnitude.
Status check_vector(const Eigen::Vector3d& value, double limit, const std::string& field);
Status check_vector(const Eigen::Vector2d& value, double limit, const std::string& field);
// Checks each component as check_vector() does, and that the length of the vector is at most `limit`.
Status check_length(const Eigen::Vector3d& value, double limit, const std::string& field);
// Checks a curve by cut::validate(), and returns its errors.
Status check_curve(const cut::Curve& curve, const std::string& field);
// Checks that the id of a vertex is not negative: kInvalidArgument UNKNOWN_VERTEX. The sheet checks that the vertex
// exists.
Status check_vertex_id(mesh::VertexId vertex, const std::string& field);

}  // namespace kerf::scene
