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

// Holds content that a message has itself, or the name of a file that has it.
struct ContentOrFile {
  std::string content;
  const std::string& file;
  std::string content_field = "text";
};
// Returns the content, which is read from the file if one is named. Errors, all with field `path`.file:
// `kind`_FILE_REFUSED if a file is named and there is no reader, as required for network requests; `kind`_TWICE if both
// content and file are given; those of the reader.
Result<std::string> read_content(ContentOrFile from, const FileReader& read_file, const std::string& kind,
                                 const std::string& path);

struct DecodedCurve {
  cut::Curve curve;
  std::vector<std::string> remarks;  // Parts of a drawing that are not in the curve.
  bool is_drawing = false;           // The curve is a drawing, which is fitted to the sheet unless it is placed.
  bool is_placed = false;            // The drawing has its true size and place.
};

// Decodes a curve without validating it. `dashes`: dashed strokes of a drawing become dashes. Errors: no kind chosen
// (CHOICE_MISSING, field `path`), weights not as many as points (LENGTH_MISMATCH), and those of decode_drawing().
Result<DecodedCurve> decode_curve(const v1::Curve& curve, const std::string& path, const FileReader& read_file,
                                  bool dashes = false);
// Encodes a curve; a drawing becomes its path.
void encode_curve(const cut::Curve& curve, v1::Curve& message);

// Returns kInvalidArgument FIELD_MISSING, for an absent message that has no default.
Error missing(const std::string& path);
// Returns kInvalidArgument CHOICE_MISSING, for a oneof without a member. `choices`: text for users, "bezier, polyline
// or circle".
Error choice_missing(const std::string& path, const std::string& choices);
// Returns kInvalidArgument UNKNOWN_ENUM_VALUE.
Error unknown_enum(const std::string& path, int value);
// Prefixes the field of a part's error, so that it applies to the whole.
Error within(const std::string& prefix, Error error);

}  // namespace kerf::wire
