#pragma once

// Mesh files of flat drawings that are placed in space, and the sheets made of them.
#include <array>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/mesh/build/obj_import.h"
#include "server/core/mesh/build/sheet_assembly.h"

namespace kerf::mesh {

using Placing = std::function<Eigen::Vector3d(const Eigen::Vector2d&)>;

struct FlatDrawing {
  std::vector<Eigen::Vector2d> points;
  std::vector<std::vector<int>> faces;  // indices into points, counter-clockwise
};

inline std::string vertex_line(const Eigen::Vector3d& at, const char* format) {
  std::string text = "v";
  for (const double value : at) {
    std::array<char, 64> number{};
    std::snprintf(number.data(), number.size(), format, value);
    text += std::string(" ") + number.data();
  }
  return text + "\n";
}

inline std::string obj_of(const FlatDrawing& drawing, const Placing& placing, const char* format = "%.17g") {
  std::string text;
  for (const Eigen::Vector2d& point : drawing.points) text += vertex_line(placing(point), format);
  for (const std::vector<int>& face : drawing.faces) {
    text += "f";
    for (const int corner : face) text += " " + std::to_string(corner + 1);
    text += "\n";
  }
  return text;
}

// Writes the corners of each face again.
inline std::string soup_of(const FlatDrawing& drawing, const Placing& placing, const char* format) {
  std::string text;
  for (const std::vector<int>& face : drawing.faces) {
    for (const int corner : face) text += vertex_line(placing(drawing.points[corner]), format);
    text += "f";
    for (std::size_t i = face.size(); i > 0; --i) text += " -" + std::to_string(i);
    text += "\n";
  }
  return text;
}

inline Eigen::Vector3d level(const Eigen::Vector2d& at) {
  return {at.x(), at.y(), 0.0};
}
// Two unit vectors across each other, along no axis.
inline Eigen::Vector3d oblique(const Eigen::Vector2d& at) {
  return Eigen::Vector3d(0.1, -0.7, 0.3) + at.x() * Eigen::Vector3d(2, 3, 6) / 7.0 +
         at.y() * Eigen::Vector3d(-6, -2, 3) / 7.0;
}
// Folded along the line y = 0.
inline Eigen::Vector3d folded(const Eigen::Vector2d& at) {
  return at.y() > 0.0 ? oblique(at)
                      : Eigen::Vector3d(oblique({at.x(), 0.0}) + at.y() * Eigen::Vector3d(3, -6, 2) / 7.0);
}

inline Result<FileSheet> try_sheet(const std::string& text, const MeshReading& reading = {}) {
  const Result<MeshFile> file = read_obj(text, reading.version);
  EXPECT_TRUE(file.ok()) << file.error().message;
  return make_sheet(*file, reading);
}

inline FileSheet whole_sheet(const std::string& text, const MeshReading& reading = {}) {
  Result<FileSheet> made = try_sheet(text, reading);
  EXPECT_TRUE(made.ok()) << made.error().message;
  EXPECT_EQ(made->mesh.find_violation(), std::nullopt);
  return std::move(made).value();
}

inline std::string all_notes(const FileSheet& sheet) {
  std::string all;
  for (const std::string& note : sheet.imported.notes) all += note + "\n";
  return all;
}

}  // namespace kerf::mesh
