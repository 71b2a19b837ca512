#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "server/cut/cut.h"
#include "tests/support/vertex_sources.h"

// What every cut is checked by, whatever it is. Each function returns what is wrong in words, or nothing.
namespace kerf::cut {

// Twice the exact area of all solid triangles, lattice units squared.
inline mesh::Int128 doubled_solid_area(const mesh::TriangleMesh& mesh) {
  mesh::Int128 sum = 0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const auto& p = mesh.points(t);
    sum += mesh::doubled_area(mesh.at(p[0]), mesh.at(p[1]), mesh.at(p[2]));
  }
  return sum;
}

// Whether an edge of the border runs neither along x nor along y.
inline bool has_slanted_border(const mesh::TriangleMesh& mesh) {
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (!mesh.is_solid(t) || (mesh.locks(t, k) & mesh::kLockBorder) == 0) continue;
      const mesh::LatticePoint& a = mesh.at(mesh.points(t)[mesh::next_corner(k)]);
      const mesh::LatticePoint& b = mesh.at(mesh.points(t)[mesh::previous_corner(k)]);
      if (a.x != b.x && a.y != b.y) return true;
    }
  }
  return false;
}

// Boundary loops of the opened mesh: border and lips. Each vertex is on at most one loop, once. A lip of one edge whose
// two sides share both ends encloses nothing and is no loop.
inline int count_boundary_loops(const mesh::TriangleMesh& mesh) {
  std::vector<mesh::VertexId> next(static_cast<std::size_t>(mesh.num_vertices()), mesh::kNone);
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    for (int k = 0; k < 3; ++k) {
      if (mesh.neighbour(t, k) != mesh::kNone) continue;
      const auto& v = mesh.vertices(t);
      next[static_cast<std::size_t>(v[mesh::next_corner(k)])] = v[mesh::previous_corner(k)];
    }
  }
  int loops = 0;
  for (std::size_t start = 0; start < next.size(); ++start) {
    if (next[start] == mesh::kNone) continue;
    int edges = 0;
    for (std::size_t at = start; next[at] != mesh::kNone; ++edges) {
      const std::size_t following = static_cast<std::size_t>(next[at]);
      next[at] = mesh::kNone;
      at = following;
    }
    if (edges > 2) ++loops;
  }
  return loops;
}

// Whether some place has more vertices than before, or there are more pieces. A new point on an older lip has two
// vertices without having opened anything.
inline bool has_opened(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after) {
  if (after.num_pieces() != before.num_pieces()) return true;
  std::vector<int> gained(static_cast<std::size_t>(after.num_points()), 0);
  for (mesh::VertexId v = 0; v < after.num_vertices(); ++v) ++gained[static_cast<std::size_t>(after.point(v))];
  for (mesh::VertexId v = 0; v < before.num_vertices(); ++v) --gained[static_cast<std::size_t>(before.point(v))];
  for (mesh::PointId p = 0; p < after.num_points(); ++p) {
    const int more = gained[static_cast<std::size_t>(p)];
    if (more <= 0) continue;
    if (p < before.num_points() || more > 2) return true;
    const mesh::Location there = before.locate(after.at(p));
    const bool was_lip =
        there.kind == mesh::Location::Kind::kEdge && (before.locks(there.triangle, there.corner) & mesh::kLockCut) != 0;
    if (more == 2 && !was_lip) return true;
  }
  return false;
}

inline double distance_to_segment_m(const Eigen::Vector2d& point, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double t = std::clamp((point - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - a - t * along).norm();
}

// Every stretch of the planned path inside the sheet must lie on lips or on the border, within the deviation reported.
inline std::optional<std::string> find_uncovered_path(const mesh::TriangleMesh& after, const CutPlan& plan,
                                                      const CutReport& report) {
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> locked;
  for (mesh::TriangleId t = 0; t < after.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (!after.is_solid(t) || (after.locks(t, k) & mesh::kLocksThatOpen) == 0) continue;
      locked.emplace_back(after.point_position(after.points(t)[mesh::next_corner(k)]),
                          after.point_position(after.points(t)[mesh::previous_corner(k)]));
    }
  }
  const double allowed = report.deviation_m - plan.curve_deviation_m;
  for (const Stroke& stroke : plan.strokes) {
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      const Eigen::Vector2d along = stroke.points[i + 1] - stroke.points[i];
      const double samples = 6.0 * std::ceil(along.norm() / plan.edge_length_m);
      for (double k = 0.0; k <= samples; ++k) {
        const Eigen::Vector2d point = stroke.points[i] + (k / samples) * along;
        const mesh::Location location = after.locate(after.lattice().nearest(point));
        if (!after.is_solid(location.triangle)) continue;
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& [a, b] : locked) nearest = std::min(nearest, distance_to_segment_m(point, a, b));
        if (nearest <= allowed) continue;
        std::ostringstream text;
        text << "the path at (" << point.transpose() << ") is " << nearest << " m from the nearest lip, " << allowed
             << " m allowed";
        return text.str();
      }
    }
  }
  return std::nullopt;
}

// Everything that must hold after any applied cut. `before`: a copy of the mesh from before it.
inline std::optional<std::string> find_cut_violation(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after,
                                                     const CutOutcome& outcome) {
  if (std::optional<std::string> violation = after.find_violation()) return violation;
  // A point on a slanted border is rounded to the lattice, by half a unit an axis: it takes or gives a triangle over
  // the edge it is on, which is no longer than the domain. On borders along an axis it stays on the edge.
  const mesh::Int128 change = doubled_solid_area(after) - doubled_solid_area(before);
  const mesh::Int128 allowed = has_slanted_border(before)
                                   ? mesh::Int128{after.num_points() - before.num_points()} * mesh::Lattice::kHalfDomain
                                   : mesh::Int128{0};
  if (change > allowed || -change > allowed) return "the rest area changed";
  if (auto wrong = test::find_wrong_source(before, after, outcome.edit.added_vertices)) return wrong;
  if (auto wrong = test::find_wrong_source(before, after, outcome.edit.moved_vertices)) return wrong;
  if (!has_opened(before, after)) return "an applied cut opened nothing";
  const int added = after.num_vertices() - before.num_vertices();
  if (outcome.report.new_vertices != added) return "new_vertices is not the number of vertices added";
  if (outcome.report.pieces != after.num_pieces()) return "pieces is not that of the mesh";
  if (outcome.report.new_triangles != after.num_solid_triangles() - before.num_solid_triangles()) {
    return "new_triangles is not the number of solid triangles added";
  }
  for (mesh::TriangleId t = 0; t < before.num_triangle_slots(); ++t) {
    const bool listed =
        std::binary_search(outcome.edit.rewritten_triangles.begin(), outcome.edit.rewritten_triangles.end(), t);
    if (!listed && before.is_solid(t) && before.vertices(t) != after.vertices(t)) {
      return "slot " + std::to_string(t) + " changed but is not listed as rewritten";
    }
  }
  return std::nullopt;
}

}  // namespace kerf::cut
