#include "tests/audit/shape_audit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/audit/exact_geometry.h"

namespace kerf::audit {
namespace {

using mesh::LatticePoint;
using mesh::MeshData;
using mesh::TriangleRecord;

// Returns the positions of a triangle's corners, in a fixed order.
std::array<LatticePoint, 3> places_of(const MeshData& data, const TriangleRecord& r) {
  std::array<LatticePoint, 3> places{};
  for (std::size_t k = 0; k < 3; ++k) places[k] = data.points[index(r.points[k])].at;
  std::sort(places.begin(), places.end());
  return places;
}

// Returns the distance of p and q in the rest shape, lattice units; on a curved one, measured on the facet of r.
double length_of(const MeshData& data, const TriangleRecord& r, const LatticePoint& p, const LatticePoint& q) {
  const Eigen::Vector2d flat(static_cast<double>(p.x - q.x), static_cast<double>(p.y - q.y));
  return data.surface ? (data.surface->facets[index(r.region)].axes * flat).norm() : std::hypot(flat.x(), flat.y());
}

double area_ratio_of(const MeshData& data, const TriangleRecord& r) {
  if (!data.surface) return 1.0;
  const Eigen::Matrix<double, 3, 2>& axes = data.surface->facets[index(r.region)].axes;
  return std::sqrt((axes.transpose() * axes).determinant());
}

}  // namespace

Finding find_shape_flaw(const MeshData& old, const MeshData& now, const std::vector<std::size_t>& old_solid,
                        const cut::CutOutcome& outcome) {
  const cut::CutQuality& quality = outcome.report.quality;
  std::vector<std::array<LatticePoint, 3>> old_places;
  for (const std::size_t t : old_solid) old_places.push_back(places_of(old, old.triangles[t]));
  std::sort(old_places.begin(), old_places.end());
  double least_angle = 180.0, most_aspect = 0.0, least_height = std::numeric_limits<double>::infinity();
  for (const mesh::TriangleId t : outcome.edit.rewritten_triangles) {
    const TriangleRecord& r = now.triangles[index(t)];
    if (!is_solid(r)) continue;
    // A triangle with a new point is new, even if an old triangle had the same places: relaxing may have moved an old
    // point away.
    const bool has_new_point =
        std::any_of(r.points.begin(), r.points.end(), [&](mesh::PointId p) { return index(p) >= old.points.size(); });
    if (!has_new_point && std::binary_search(old_places.begin(), old_places.end(), places_of(now, r))) continue;
    const LatticePoint& a = now.points[index(r.points[0])].at;
    const LatticePoint& b = now.points[index(r.points[1])].at;
    const LatticePoint& c = now.points[index(r.points[2])].at;
    std::array<double, 3> side{length_of(now, r, a, b), length_of(now, r, b, c), length_of(now, r, c, a)};
    std::sort(side.begin(), side.end());
    const double doubled = area_ratio_of(now, r) * static_cast<double>(turn(minus(b, a), minus(c, a)));
    const double angle = std::asin(std::min(1.0, doubled / (side[1] * side[2]))) * 180.0 / std::numbers::pi;
    const double height = doubled / side[2];
    least_angle = std::min(least_angle, angle);
    least_height = std::min(least_height, height * now.lattice.spacing);
    most_aspect = std::max(most_aspect, side[2] / height);
  }
  if (least_angle == 180.0) return std::nullopt;  // a cut along existing edges makes no triangles
  if (std::abs(quality.min_angle_deg - least_angle) > 1e-5) return "min_angle_deg is not that of the triangles";
  if (std::abs(quality.min_height_m - least_height) > 1e-9 * least_height) return "min_height_m is wrong";
  if (std::abs(quality.max_aspect - most_aspect) > 1e-9 * most_aspect) return "max_aspect is wrong";
  return std::nullopt;
}

}  // namespace kerf::audit
