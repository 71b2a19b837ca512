#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace kerf::mesh {

enum class PolygonKind {
  kSound,
  kNoArea,  // all corners lie on a line, or at one point
  kCrossesItself,
};

struct TriangulatedPolygon {
  PolygonKind kind = PolygonKind::kNoArea;
  std::vector<std::array<std::int32_t, 3>> triangles;  // corners, turning as the polygon does; empty unless kSound
};

// Divides a polygon into triangles that use its corners alone, and all of them. Triangles stay as they are; a quad is
// split at its first corner if both parts turn alike. Other polygons lose ears, the best shaped first, and are then
// made constrained Delaunay (Lawson 1977), as far as a bounded number of flips brings them. Corners may lie on a
// straight line, and places may repeat where the border touches itself. All decisions are exact on a lattice.
// `corners`: in the plane, m, finite.
TriangulatedPolygon triangulate_polygon(std::span<const Eigen::Vector2d> corners);

// Returns the corners of a polygon in space in the plane across its area vector; its turn there is counter-clockwise.
// Without area all lie on a line.
std::vector<Eigen::Vector2d> in_own_plane(std::span<const Eigen::Vector3d> corners);

}  // namespace kerf::mesh
