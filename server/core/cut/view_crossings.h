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

// The vertices of a sheet as a camera sees them. Each is moved by up to kJitter units, always by the same amount. So
// triangles seen edge-on become thin triangles instead of lines, and curves run through them as through any other.
struct Screen {
  static constexpr double kUnitsPerPx = 1 << 20;  // lattice units per pixel
  static constexpr std::int64_t kJitter = 8;      // lattice units; largest shift in x, and in y

  struct Vertex {
    mesh::LatticePoint at;   // pixels times kUnitsPerPx, y down
    double inverse_w = 0.0;  // 1 / w of the clip coordinates; linear in the picture within a triangle
    double depth = 0.0;      // m, along the camera's axis
    bool seen = false;       // in front of the camera and not absurdly far beside the picture
  };
  std::vector<Vertex> vertices;  // by VertexId
};

Screen project(const linear::VertexField& positions, const View& view);

// Rounds a point of the picture to the lattice of Screen.
mesh::LatticePoint screen_point(const Eigen::Vector2d& px);

// An end of a ViewInterval.
struct ViewNode {
  enum class Kind {
    kEdge,   // on the edge between vertices `low` < `high`
    kJoint,  // at a point of the curve, inside the triangle
    kFree,   // anywhere: the layer rule leaves out the segment from here on
  };
  Kind kind = Kind::kFree;
  std::int32_t low = 0;            // kEdge: vertex; kJoint: number of the point, counted over all strokes
  std::int32_t high = 0;           // kEdge: vertex; kJoint: triangle
  double at = 0.0;                 // -, in [0, 1], place along the segment
  Eigen::Vector2d rest{0.0, 0.0};  // m, material coordinates; equal bit for bit in both triangles at an edge
  double inverse_w = 0.0;          // as of Screen::Vertex
  double depth = 0.0;              // m
};

// The part of one segment of the curve that lies in one triangle.
struct ViewInterval {
  mesh::TriangleId triangle = mesh::kNone;
  std::int32_t segment = 0;  // number of the segment, counted over all strokes
  ViewNode begin, end;       // begin.at < end.at
};

// Bounds how far a point in one triangle moves in material space if its picture moves.
struct ViewStretch {
  double m_per_px = 0.0;
  double longest_m = 0.0;  // m, the triangle's longest edge, beyond which it cannot move
};

struct ViewCrossings {
  std::vector<ViewInterval> intervals;  // by segment, then by begin.at, then by triangle
  std::vector<ViewStretch> stretches;   // one for each triangle that the curve meets
  std::int32_t behind = 0;              // triangles left out, since a vertex is not seen or the triangle is seen as a
                                        // line
};

// Returns the intervals of the strokes (pixels) in all solid triangles, of all layers. Error: kResourceExhausted
// VIEW_WORK_BUDGET (too many pairs of a triangle and a segment).
Result<ViewCrossings> find_crossings(const mesh::TriangleMesh& mesh, const Screen& screen,
                                     const std::vector<Stroke>& strokes);

}  // namespace kerf::cut
