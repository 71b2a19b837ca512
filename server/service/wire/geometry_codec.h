#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "kerf/v1/geometry.pb.h"
#include "server/base/result.h"
#include "server/core/scene/command.h"

// kerf.v1 vectors and curves, and the errors that all decoders share.
namespace kerf::wire {

Eigen::Vector2d decode_vector(const v1::Vec2& vector);
Eigen::Vector3d decode_vector(const v1::Vec3& vector);
void encode_vector(const Eigen::Vector2d& vector, v1::Vec2& message);
void encode_vector(const Eigen::Vector3d& vector, v1::Vec3& message);

// Reads a file that a scene file names.
using FileReader = std::function<Result<std::string>(const std::string& path)>;

// The content of a message that holds it, or in scene files the name of a file with it. Errors: `kind`_FILE_REFUSED
// without a reader, as it must be for what comes over the network; `kind`_TWICE where both are given; those of the
// reader. All have field `path`.file.
struct ContentOrFile {
  std::string content;
  const std::string& file;
  std::string content_field = "text";
};
Result<std::string> read_content(ContentOrFile from, const FileReader& read_file, const std::string& kind,
                                 const std::string& path);

struct DecodedCurve {
  cut::Curve curve;
  std::vector<std::string> remarks;  // what of a drawing is not in the curve
  bool is_drawing = false;           // its place on the sheet is not its own: it is fitted
};

// Unchecked, but that a kind is chosen (CHOICE_MISSING, field `path`), that weights are as many as points
// (LENGTH_MISMATCH), and what makes a drawing into a path: svg::read(), read_content() with kind SVG.
Result<DecodedCurve> decode_curve(const v1::Curve& curve, const std::string& path, const FileReader& read_file);
// A drawing comes back as the path that it became.
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
