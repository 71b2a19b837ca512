#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/stroke.h"
#include "server/core/cut/view.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::cut {

// The vertices of a sheet as a camera sees them. Each is moved by up to kJitter units, always the same way: triangles
// that are seen edge-on, which would have no inside, are thin ones instead, and a curve runs through them like through
// any other.
struct Screen {
  static constexpr double kUnitsPerPx = 1 << 20;  // lattice units a pixel
  static constexpr std::int64_t kJitter = 8;      // lattice units

  struct Vertex {
    mesh::LatticePoint at;   // pixels times kUnitsPerPx, y down
    double inverse_w = 0.0;  // 1 / clip w: linear on the picture within a triangle
    double depth = 0.0;      // m, along the camera's axis
    bool seen = false;       // in front of the camera and not absurdly far beside the picture
  };
  std::vector<Vertex> vertices;  // by VertexId
};

Screen project(const mesh::VertexField& positions, const View& view);

// A screen point on the lattice of Screen.
mesh::LatticePoint screen_point(const Eigen::Vector2d& px);

// End of an interval.
struct ViewNode {
  enum class Kind {
    kEdge,   // on the edge between vertices `low` < `high`
    kJoint,  // at a point of the curve, inside the triangle
    kFree,   // left out from here on
  };
  Kind kind = Kind::kFree;
  std::int32_t low = 0;            // kEdge: vertex; kJoint: point of the curve, over all strokes
  std::int32_t high = 0;           // kEdge: vertex; kJoint: triangle
  double at = 0.0;                 // -, in [0, 1], along the segment
  Eigen::Vector2d rest{0.0, 0.0};  // m; equal bit for bit in both triangles at an edge
  double inverse_w = 0.0;          // as of Screen::Vertex
  double depth = 0.0;              // m
};

// The part of one segment of the curve that one triangle holds.
struct ViewInterval {
  mesh::TriangleId triangle = mesh::kNone;
  std::int32_t segment = 0;  // over all strokes
  ViewNode begin, end;       // begin.at < end.at
};

// Largest shift of a point in rest space for a shift of its picture, in one triangle.
struct ViewStretch {
  double m_per_px = 0.0;
  double longest_m = 0.0;  // m, the triangle's longest edge: it cannot move farther there
};

struct ViewCrossings {
  std::vector<ViewInterval> intervals;  // by segment, then by begin.at, then by triangle
  std::vector<ViewStretch> stretches;   // of the triangles met
  std::int32_t behind = 0;              // triangles left out since not all their vertices are seen
};

// Every interval of the strokes (pixels) in a solid triangle, all layers. Error: kResourceExhausted VIEW_WORK_BUDGET.
Result<ViewCrossings> find_crossings(const mesh::TriangleMesh& mesh, const Screen& screen,
                                     const std::vector<Stroke>& strokes);

}  // namespace kerf::cut
