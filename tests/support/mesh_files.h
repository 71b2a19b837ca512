#pragma once

// Writes mesh files for tests of import.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/mesh/build/mesh_import.h"

namespace kerf::test {

enum class PlyKind { kAscii, kLittleEndian, kBigEndian };
inline constexpr std::array<PlyKind, 3> kPlyKinds{PlyKind::kAscii, PlyKind::kLittleEndian, PlyKind::kBigEndian};

// Returns the first lines of a PLY header.
inline std::string ply_start(PlyKind kind) {
  constexpr std::array<std::string_view, 3> kNames{"ascii", "binary_little_endian", "binary_big_endian"};
  return "ply\nformat " + std::string(kNames[static_cast<std::size_t>(kind)]) + " 1.0\n";
}

// Writes the part of a PLY file after its header.
class PlyBody {
 public:
  explicit PlyBody(PlyKind kind) : kind_(kind) {}

  template <typename Number>
  PlyBody& add(Number value) {
    if (kind_ == PlyKind::kAscii) {
      std::ostringstream word;
      word.precision(17);
      word << +value << ' ';  // + makes numbers of one byte print as numbers, not characters
      text_ += word.str();
      return *this;
    }
    std::array<char, sizeof(Number)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(Number));  // little-endian, as every machine that Kerf runs on
    if (kind_ == PlyKind::kBigEndian) std::reverse(bytes.begin(), bytes.end());
    text_.append(bytes.data(), bytes.size());
    return *this;
  }
  // Ends a vertex, face or other element.
  PlyBody& end() {
    if (kind_ == PlyKind::kAscii) text_ += '\n';
    return *this;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  PlyKind kind_;
  std::string text_;
};

// Returns a PLY file of a flat sheet of triangles at height z, with positions as doubles. Lips of cuts stay apart.
inline std::string write_ply(const mesh::IndexedMesh& sheet, PlyKind kind, double z = 0.0) {
  PlyBody body(kind);
  for (Eigen::Index v = 0; v < sheet.rest.cols(); ++v) body.add(sheet.rest(0, v)).add(sheet.rest(1, v)).add(z).end();
  for (Eigen::Index t = 0; t < sheet.triangles.cols(); ++t) {
    body.add(std::uint8_t{3});
    for (int k = 0; k < 3; ++k) body.add(static_cast<std::int32_t>(sheet.triangles(k, t)));
    body.end();
  }
  return ply_start(kind) + "comment Kerf: lips stay apart\nelement vertex " + std::to_string(sheet.rest.cols()) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
         std::to_string(sheet.triangles.cols()) + "\nproperty list uchar int vertex_indices\nend_header\n" +
         body.text();
}

// Returns a Wavefront OBJ file of a flat sheet of triangles at height z. Lips of cuts stay apart.
inline std::string write_obj(const mesh::IndexedMesh& sheet, double z = 0.0) {
  std::ostringstream text;
  text.precision(17);
  text << "# Kerf: lips stay apart\n";
  for (Eigen::Index v = 0; v < sheet.rest.cols(); ++v) {
    text << "v " << sheet.rest(0, v) << ' ' << sheet.rest(1, v) << ' ' << z << '\n';
  }
  for (Eigen::Index t = 0; t < sheet.triangles.cols(); ++t) {
    text << 'f';
    for (int k = 0; k < 3; ++k) text << ' ' << sheet.triangles(k, t) + 1;
    text << '\n';
  }
  return text.str();
}

}  // namespace kerf::test
