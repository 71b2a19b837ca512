#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "kerf/v1/geometry.pb.h"
#include "server/base/result.h"
#include "server/core/scene/command.h"

// Converts kerf.v1 vectors and curves, and makes the errors that all decoders share.
namespace kerf::wire {

Eigen::Vector2d decode_vector(const v1::Vec2& vector);
Eigen::Vector3d decode_vector(const v1::Vec3& vector);
void encode_vector(const Eigen::Vector2d& vector, v1::Vec2& message);
void encode_vector(const Eigen::Vector3d& vector, v1::Vec3& message);

// Reads a file named by a scene file.
using FileReader = std::function<Result<std::string>(const std::string& path)>;

// Returns content that a message holds itself, or that a file named in a scene file holds. Errors, all with field
// `path`.file: `kind`_FILE_REFUSED without a reader, as required for network requests; `kind`_TWICE if both are given;
// those of the reader.
struct ContentOrFile {
  std::string content;
  const std::string& file;
  std::string content_field = "text";
};
Result<std::string> read_content(ContentOrFile from, const FileReader& read_file, const std::string& kind,
                                 const std::string& path);

struct DecodedCurve {
  cut::Curve curve;
  std::vector<std::string> remarks;  // Parts of a drawing that are not in the curve.
  bool is_drawing = false;           // The curve has no place of its own on the sheet: it is fitted.
};

// Decodes a curve without validating it. Errors: no kind chosen (CHOICE_MISSING, field `path`), weights not as many as
// points (LENGTH_MISMATCH), and those of converting a drawing: svg::read(), read_content() with kind SVG.
Result<DecodedCurve> decode_curve(const v1::Curve& curve, const std::string& path, const FileReader& read_file);
// Encodes a curve; a drawing becomes its path.
void encode_curve(const cut::Curve& curve, v1::Curve& message);

// Returns kInvalidArgument FIELD_MISSING, for a message without default.
Error missing(const std::string& path);
// Returns kInvalidArgument CHOICE_MISSING, for a oneof without a member. `choices`: text for users, "bezier, polyline
// or circle".
Error choice_missing(const std::string& path, const std::string& choices);
// Returns kInvalidArgument UNKNOWN_ENUM_VALUE.
Error unknown_enum(const std::string& path, int value);
// Prefixes the field of a part's error, so that it applies to the whole.
Error within(const std::string& prefix, Error error);

}  // namespace kerf::wire
