#include "server/core/cut/cut_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/base/elementary.h"
#include "server/base/sort_unique.h"
#include "server/core/mesh/id_map.h"
#include "server/core/mesh/lip_corner.h"
#include "server/core/mesh/triangle_shape.h"

namespace kerf::cut {

using mesh::PointId;
using mesh::TriangleId;

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

// Tolerance of comparisons of angles, as points are rounded to the lattice.  degrees
constexpr double kAngleRounding = 1.0e-6;

double angle_of(double cosine) {
  return arc_cosine(std::clamp(cosine, -1.0, 1.0)) * kDegrees;
}

std::array<PointId, 3> sorted(std::array<PointId, 3> points) {
  std::sort(points.begin(), points.end());
  return points;
}

// Collects the triangles with a corner at p, and those that share a vertex of the opened mesh with one of them.
std::vector<TriangleId> two_rings(const mesh::TriangleMesh& mesh, PointId p) {
  std::vector<TriangleId> fan;
  mesh.fan_around(p, fan);
  std::vector<mesh::VertexId> vertices;
  for (const TriangleId t : fan) {
    if (!mesh.is_solid(t)) continue;
    vertices.insert(vertices.end(), mesh.vertices(t).begin(), mesh.vertices(t).end());
  }
  sort_unique(vertices);
  std::vector<TriangleId> rings;
  for (const mesh::VertexId v : vertices) {
    mesh.triangles_around(v, fan);
    rings.insert(rings.end(), fan.begin(), fan.end());
  }
  sort_unique(rings);
  return rings;
}

// Lists the sharp corners near the triangles `below` (sorted). Returns those of `below` that lie within two rings of
// such a corner, sorted.
std::vector<TriangleId> list_corners(const mesh::TriangleMesh& mesh, std::span<const TriangleId> below,
                                     CutQuality& quality) {
  std::vector<PointId> candidates;
  std::vector<TriangleId> fan;
  for (const TriangleId t : below) {
    for (const mesh::VertexId v : mesh.vertices(t)) {
      mesh.triangles_around(v, fan);
      for (const TriangleId u : fan) candidates.insert(candidates.end(), mesh.points(u).begin(), mesh.points(u).end());
    }
  }
  sort_unique(candidates);
  mesh::LipCorners corners(mesh);
  std::vector<TriangleId> excused;
  for (const PointId p : candidates) {
    const double cos_corner = corners.sharpest(p);
    if (cos_corner <= mesh::LipCorners::kCosSharp) continue;
    SharpCorner corner{mesh.point_position(p), angle_of(cos_corner), 0};
    for (const TriangleId t : two_rings(mesh, p)) {
      if (!std::binary_search(below.begin(), below.end(), t)) continue;
      excused.push_back(t);
      ++corner.triangles_below;
    }
    if (corner.triangles_below == 0) continue;
    ++quality.num_corners;
    quality.corners.push_back(corner);
  }
  std::stable_sort(quality.corners.begin(), quality.corners.end(),
                   [](const SharpCorner& a, const SharpCorner& b) { return a.angle_deg < b.angle_deg; });
  if (quality.corners.size() > kMaxListedCorners) quality.corners.resize(kMaxListedCorners);
  sort_unique(excused);
  return excused;
}

// Counts a triangle whose smallest angle, `angle` (degrees), is below min_angle_deg, at its place. Returns the least
// angle allowed at that place, degrees.
double count_below(mesh::Strands::Place place, double angle, double min_angle_deg, CutQuality& quality) {
  StrandQuality& strands = quality.strands;
  if (place == mesh::Strands::Place::kElsewhere) {
    quality.elsewhere_min_angle_deg = std::min(quality.elsewhere_min_angle_deg, angle);
    return min_angle_deg;
  }
  ++strands.triangles_below;
  if (place == mesh::Strands::Place::kNear) {
    strands.min_angle_deg = std::min(strands.min_angle_deg, angle);
    return strands.asked_angle_deg;
  }
  ++strands.narrow_below;
  strands.narrow_min_angle_deg = std::min(strands.narrow_min_angle_deg, angle);
  return 0.0;
}

}  // namespace

std::vector<TriangleId> new_triangles(const mesh::TriangleMesh& mesh, const mesh::UndoLog& undo,
                                      std::span<const TriangleId> rewritten, std::span<const PointId> moved) {
  // A triangle with a new or moved corner is new. Any other is old if it kept its slot, or is one of the old triangles
  // that changed slots.
  const auto is_made = [&](PointId p) {
    return p >= undo.num_points || std::binary_search(moved.begin(), moved.end(), p);
  };
  std::vector<std::array<PointId, 3>> old;
  mesh::IdMap kept;
  for (const auto& [t, record] : undo.triangles) {
    if (mesh.points(t) == record.points && mesh.is_solid(t)) {
      kept.add(t);
    } else {
      old.push_back(sorted(record.points));
    }
  }
  std::sort(old.begin(), old.end());
  std::vector<TriangleId> made;
  for (const TriangleId t : rewritten) {
    if (!mesh.is_solid(t)) continue;
    const std::array<PointId, 3>& p = mesh.points(t);
    const bool is_old = std::none_of(p.begin(), p.end(), is_made) &&
                        (kept.has(t) || std::binary_search(old.begin(), old.end(), sorted(p)));
    if (!is_old) made.push_back(t);
  }
  return made;
}

mesh::StrandWidths strand_widths(const mesh::TriangleMesh& mesh, const CutOptions& options) {
  if (options.method == Method::kElement) return {};
  const double edge_length = mesh.edge_lengths().mean / mesh.lattice().spacing;
  return {kNearStrands * edge_length, kNarrowGap * edge_length};
}

CutQuality measure_quality(const mesh::TriangleMesh& mesh, std::span<const TriangleId> triangles, double min_angle_deg,
                           const mesh::StrandWidths& strand_widths) {
  CutQuality quality;
  quality.strands.asked_angle_deg = kStrandAngle * min_angle_deg;
  quality.triangles = static_cast<std::int32_t>(triangles.size());
  if (triangles.empty()) return quality;
  double smallest_height = std::numeric_limits<double>::infinity();
  double sum_angle = 0.0, sum_aspect = 0.0, sum_ratio = 0.0;
  std::vector<TriangleId> below, broken;
  mesh::Strands strands(mesh, strand_widths, &mesh.edge_lengths());
  for (const TriangleId t : triangles) {
    const mesh::TriangleShape shape = rest_shape_of(mesh, t);
    const double angle = angle_of(shape.cos_smallest);
    const double aspect = shape.longest / shape.smallest_height;
    const double ratio = shape.longest / shape.shortest;
    quality.min_angle_deg = std::min(quality.min_angle_deg, angle);
    quality.max_aspect = std::max(quality.max_aspect, aspect);
    quality.max_edge_ratio = std::max(quality.max_edge_ratio, ratio);
    smallest_height = std::min(smallest_height, shape.smallest_height);
    sum_angle += angle, sum_aspect += aspect, sum_ratio += ratio;
    if (angle >= min_angle_deg - kAngleRounding) {
      quality.elsewhere_min_angle_deg = std::min(quality.elsewhere_min_angle_deg, angle);
      continue;
    }
    below.push_back(t);
    const double asked = count_below(strands.place_of(t, shape), angle, min_angle_deg, quality);
    if (angle < asked - kAngleRounding) broken.push_back(t);
  }
  const double count = static_cast<double>(triangles.size());
  quality.mean_min_angle_deg = sum_angle / count;
  quality.mean_aspect = sum_aspect / count;
  quality.mean_edge_ratio = sum_ratio / count;
  quality.min_height_m = smallest_height * mesh.lattice().spacing;
  quality.triangles_below_angle = static_cast<std::int32_t>(below.size());
  const std::vector<TriangleId> excused = list_corners(mesh, below, quality);
  quality.triangles_below_contract =
      static_cast<std::int32_t>(std::count_if(broken.begin(), broken.end(), [&](TriangleId t) {
        return !std::binary_search(excused.begin(), excused.end(), t);
      }));
  return quality;
}

}  // namespace kerf::cut
