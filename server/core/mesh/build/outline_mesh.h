#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

inline constexpr double kMinOutlineEdge = 1e-9;   // -; shortest edge length that may be requested, as a fraction of the
                                                  // larger side of the outline
inline constexpr double kMaxOutlineAngle = 28.0;  // degrees

// A closed curve of an outline as a fine polygon.
struct OutlineContour {
  std::vector<Eigen::Vector2d> points;  // m, |coordinate| <= kMaxRestCoordinate; the last joins the first
  std::vector<std::size_t> corners;     // indices of points that must become vertices, sorted
  std::string field;                    // path of the contour in the request, for errors
};

// An edge length wanted at a point, or along the segments between several: `length` there, and away from it
// length + growth * distance.
struct OutlineSize {
  std::vector<Eigen::Vector2d> points;  // m, at least 1
  double length = 0.0;                  // m, edge length; >= kMinOutlineEdge times the larger side of the outline
  double growth = 0.25;                 // -, >= 0, increase of the edge length per distance
  std::string field;                    // path of the size in the request, for errors
};

struct OutlineConfig {
  std::vector<OutlineContour> contours;  // the lines of the border, then holes, in any orientation
  // Contours of the border, at least 1. They may lie in each other: what is inside an odd number of contours is sheet.
  std::size_t num_border_contours = 1;
  double edge_length = 0.0;  // m, largest edge length; 0: 1/32 of the larger side of the border
  std::vector<OutlineSize> sizes;
  double min_angle_deg = 25.0;               // degrees, in (0, kMaxOutlineAngle]
  std::int32_t max_vertices = kMaxVertices;  // at least 3
};

// Meshes what lies inside the border and outside the holes. A border of several panels makes a sheet of several pieces.
// Vertices on the contours lie on the given polygons, spaced as the sizes require, and closer together where contours
// come near each other. A full circle has at least 16 vertices. Triangles are as large as requested, graded away from
// shorter edges by 0.25 of the distance, and near equilateral. No angle is below min_angle_deg except where the outline
// forces one. The outline forces one at its own sharp corners, and where it is too narrow for floating point to
// resolve. The result is deterministic.
//
// Steps: 1. The contours are divided. 2. The inside is triangulated (constrained Delaunay) and refined (refinement.h),
// which shows where contours need more vertices for the smallest angle. 3. It is triangulated again and filled from the
// contours inwards (front_fill.h). 4. Points inside move to where the worst triangle around them is best
// (relaxation.h). 5. Triangles still below the angle are refined.
//
// Errors: kInvalidArgument OUTLINE_DEGENERATE (fewer than three different points, or smaller than 1e-9 m),
// OUTLINE_CROSSES (a contour crosses or touches itself or another), OUTLINE_NESTING (a hole that is not inside the
// sheet), OUTLINE_EDGE_LENGTH (an edge length below kMinOutlineEdge); kResourceExhausted OUTLINE_TOO_FINE: more
// than max_vertices, as estimated beforehand or as found while meshing. Fields: those of the contours and sizes,
// `edge_length`.
Result<TriangleMesh> mesh_outline(const OutlineConfig& config);

}  // namespace kerf::mesh
