#include "server/core/contact/intersections.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/core/contact/orient3d.h"

namespace kerf::contact {
namespace {

using Corners = std::array<Eigen::Vector3d, 3>;
using Signs = std::array<int, 3>;

// Finds on which side of a plane each corner lies, as far as doubles tell.
Signs filtered_sides(const FilteredPlane& plane, const Corners& corners) {
  return {plane.side(corners[0]), plane.side(corners[1]), plane.side(corners[2])};
}

bool lies_on_one_side(const Signs& sides) {
  return sides[0] == sides[1] && sides[1] == sides[2] && std::abs(sides[0]) == 1;
}

bool is_unsure(const Signs& sides) {
  return std::find(sides.begin(), sides.end(), FilteredPlane::kUnsure) != sides.end();
}

void settle_sides(const Corners& plane, const Corners& corners, Signs& sides) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (sides[k] == FilteredPlane::kUnsure) sides[k] = orient3d_exact(plane[0], plane[1], plane[2], corners[k]);
  }
}

// Returns true if corners lie strictly on both sides.
bool straddles(const Signs& sides) {
  return *std::min_element(sides.begin(), sides.end()) < 0 && *std::max_element(sides.begin(), sides.end()) > 0;
}

// Returns the corner of a triangle that straddles a plane which is alone on its side; others may lie on the plane.
std::size_t lone_corner(const Signs& sides) {
  const int lone = std::count(sides.begin(), sides.end(), 1) == 1 ? 1 : -1;
  return static_cast<std::size_t>(std::find(sides.begin(), sides.end(), lone) - sides.begin());
}

// Turns a triangle so that its lone corner comes first.
Corners turned(const Corners& corners, std::size_t first) {
  return {corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]};
}

int num_places_shared(const Corners& t, const Corners& u) {
  int count = 0;
  for (const Eigen::Vector3d& a : t) count += static_cast<int>(std::count(u.begin(), u.end(), a));
  return count;
}

// Returns true if a plane with this normal, of any length, lies strictly between both triangles, rounding included.
bool separates(const Eigen::Vector3d& normal, const Corners& t, const Corners& u) {
  double most_t = -std::numeric_limits<double>::infinity(), least_t = -most_t;
  double most_u = most_t, least_u = least_t, scale = 0.0;
  const auto project = [&](const Eigen::Vector3d& point, double& least, double& most) {
    const Eigen::Vector3d w = point - t[0];
    const double value = normal.x() * w.x() + normal.y() * w.y() + normal.z() * w.z();
    scale = std::max(scale, std::abs(normal.x() * w.x()) + std::abs(normal.y() * w.y()) + std::abs(normal.z() * w.z()));
    least = std::min(least, value);
    most = std::max(most, value);
  };
  for (const Eigen::Vector3d& point : t) project(point, least_t, most_t);
  for (const Eigen::Vector3d& point : u) project(point, least_u, most_u);
  // Each value is off by less than 4 units of 2^-53 of `scale`.
  const double slack = 0x1.0p-49 * scale + 0x1.0p-700;
  return most_t + slack < least_u || most_u + slack < least_t;
}

// Returns true if triangles in nearly one plane lie apart in it. False says nothing.
bool lies_apart(const Corners& t, const Eigen::Vector3d& normal_t, const Corners& u, const Eigen::Vector3d& normal_u) {
  const auto has_separating_edge = [&](const Corners& corners, const Eigen::Vector3d& normal) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (separates(normal.cross(corners[(k + 1) % 3] - corners[k]), t, u)) return true;
    }
    return false;
  };
  return has_separating_edge(t, normal_t) || has_separating_edge(u, normal_u);
}

// Returns true if two triangles pass through each other; see the header.
//
// A triangle that straddles the plane of the other meets the line that both planes have in common in an interval. The
// interiors meet where both intervals overlap in more than a point (Guigue, Devillers 2003, "Fast and Robust
// Triangle-Triangle Overlap Test Using Orientation Predicates"). The lone corners a and p come first, and each triangle
// is turned over if the other's lone corner is behind it. The intervals then end on ab and ac, and on pq and pr. Two
// more orientations tell their order.
bool passes_through(const Corners& t, const Corners& u) {
  const FilteredPlane plane_u(u[0], u[1], u[2]);
  Signs sides_t = filtered_sides(plane_u, t);
  if (lies_on_one_side(sides_t)) return false;
  const FilteredPlane plane_t(t[0], t[1], t[2]);
  Signs sides_u = filtered_sides(plane_t, u);
  if (lies_on_one_side(sides_u)) return false;
  if (is_unsure(sides_t) || is_unsure(sides_u)) {
    // Triangles with an edge in common meet nowhere else, except in one plane.
    if (lies_apart(t, plane_t.normal(), u, plane_u.normal()) || num_places_shared(t, u) >= 2) return false;
    settle_sides(u, t, sides_t);
    if (!straddles(sides_t)) return false;
    settle_sides(t, u, sides_u);
  }
  if (!straddles(sides_t) || !straddles(sides_u)) return false;
  const std::size_t lone_t = lone_corner(sides_t), lone_u = lone_corner(sides_u);
  const Corners first = turned(t, lone_t), second = turned(u, lone_u);
  const Eigen::Vector3d &a = first[0], &p = second[0];
  const Eigen::Vector3d &b = first[sides_u[lone_u] > 0 ? 1 : 2], &c = first[sides_u[lone_u] > 0 ? 2 : 1];
  const Eigen::Vector3d &q = second[sides_t[lone_t] > 0 ? 1 : 2], &r = second[sides_t[lone_t] > 0 ? 2 : 1];
  return orient3d(a, b, p, q) < 0 && orient3d(a, c, p, r) > 0;
}

// Returns a coordinate as orient3d() takes it; NaN if it cannot.
double usable(double x) {
  if (std::abs(x) < kLeastCoordinate) return 0.0;
  return std::abs(x) <= kMostCoordinate ? x : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

// Triangles in boxes that only touch do not pass through each other. What they share lies in the plane between the
// boxes, and if an interior point lies there, so does the whole triangle. So it suffices to look where boxes overlap.
template <typename Found>
void IntersectionSearch::for_each_pair(Triangles triangles, const linear::VertexField& positions, const Found& found) {
  points_.resize(static_cast<std::size_t>(positions.cols()));
  for (std::size_t v = 0; v < points_.size(); ++v) {
    points_[v] = positions.col(static_cast<Eigen::Index>(v)).unaryExpr(&usable);
  }
  const auto corners_of = [&](std::size_t t) {
    const auto& ids = triangles[t];
    return Corners{points_[static_cast<std::size_t>(ids[0])], points_[static_cast<std::size_t>(ids[1])],
                   points_[static_cast<std::size_t>(ids[2])]};
  };
  boxes_.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Corners corners = corners_of(t);
    // NaN if a corner is.
    const Eigen::Vector3d zero = 0.0 * (corners[0] + corners[1] + corners[2]);
    boxes_[t] = {corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]) + zero,
                 corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]) + zero};
  }
  tree_.build(boxes_);
  tree_.for_each_overlap([&](std::int32_t t, std::int32_t u) {
    const auto& a = triangles[static_cast<std::size_t>(t)];
    const auto& b = triangles[static_cast<std::size_t>(u)];
    if (std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end()) return;
    if (passes_through(corners_of(static_cast<std::size_t>(t)), corners_of(static_cast<std::size_t>(u)))) found(t, u);
  });
}

std::int64_t IntersectionSearch::count(Triangles triangles, const linear::VertexField& positions) {
  std::int64_t count = 0;
  for_each_pair(triangles, positions, [&count](std::int32_t, std::int32_t) { ++count; });
  return count;
}

Intersections IntersectionSearch::find(Triangles triangles, const linear::VertexField& positions,
                                       std::size_t most_pairs) {
  Intersections found;
  // A heap with the last pair on top.
  std::vector<std::array<std::int32_t, 2>>& pairs = found.pairs;
  for_each_pair(triangles, positions, [&](std::int32_t t, std::int32_t u) {
    ++found.count;
    const std::array<std::int32_t, 2> pair{std::min(t, u), std::max(t, u)};
    if (pairs.size() == most_pairs) {
      if (pairs.empty() || !(pair < pairs.front())) return;
      std::pop_heap(pairs.begin(), pairs.end());
      pairs.pop_back();
    }
    pairs.push_back(pair);
    std::push_heap(pairs.begin(), pairs.end());
  });
  std::sort_heap(pairs.begin(), pairs.end());
  return found;
}

}  // namespace kerf::contact
