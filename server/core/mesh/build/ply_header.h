#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"

namespace kerf::mesh {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };

// The eight types of the format, and three that some programs add. kOther: a name that is none of them, whose size is
// unknown.
enum class PlyType {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat32,
  kFloat64,
  kInt64,
  kUint64,
  kFloat16,
  kOther
};

// Returns the size of a number of this type, bytes; 0 for kOther.
std::size_t size_of(PlyType type);

// Meaning of a property for the sheet; kCorners is the list of a face's vertices.
enum class PlyRole { kSkipped, kX, kY, kZ, kTextureX, kTextureY, kCorners };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kInt8;
  std::optional<PlyType> count_type;  // type of the length, if the property is a list
  PlyRole role = PlyRole::kSkipped;
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;  // >= 0
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;  // in the order of the file; one is "vertex", another "face" or "tristrips"
  char line_end = '\n';              // or '\r'; with '\n', a '\r' before it counts as a blank
  std::int64_t num_lines = 0;
  std::int64_t num_vertices = 0;  // <= kMaxVertices
  bool has_texture = false;
  bool is_plane = false;        // Vertices have no z.
  bool is_kerf_export = false;  // a comment begins with kKerfComment
};

// Reads the header and removes it from the front of `file`. Errors as of parse_ply, with reason and place complete:
// PLY_HEADER, PLY_TOO_LARGE (more than kMaxVertices vertices).
Result<PlyHeader> read_ply_header(std::string_view& file);

}  // namespace kerf::mesh
