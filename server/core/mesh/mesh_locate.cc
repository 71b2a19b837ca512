// Point location and segment walks on TriangleMesh.

#include <algorithm>
#include <cmath>

#include "server/base/check.h"
#include "server/core/mesh/mesh_walk.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {
namespace {

struct CurrentMesh {
  const MeshData& data;
  [[nodiscard]] const TriangleRecord& triangle(TriangleId t) const { return data.triangles[t]; }
  [[nodiscard]] const LatticePoint& at(PointId p) const { return data.points[p].at; }
};

}  // namespace

void TriangleMesh::build_hints() {
  hints_.clear();
  hint_columns_ = hint_rows_ = 0;
  if (data_.num_solid_triangles == 0) return;
  // Makes about one cell for two triangles of average size, at most 1024 in a row or column.
  const Eigen::Vector2d size = data_.bounds.sizes();
  const double cell = std::max(std::sqrt(2.0 * size.prod() / data_.num_solid_triangles), size.maxCoeff() / 1024.0);
  hint_columns_ = std::max(1, static_cast<std::int32_t>(std::ceil(size.x() / cell)));
  hint_rows_ = std::max(1, static_cast<std::int32_t>(std::ceil(size.y() / cell)));
  hints_.assign(static_cast<std::size_t>(hint_columns_) * static_cast<std::size_t>(hint_rows_), kNone);
  for (TriangleId t = num_triangle_slots() - 1; t >= 0; --t) {
    const std::array<PointId, 3>& p = points(t);
    // Records may be damaged here; find_violation() reports them later.
    const auto [low, high] = std::minmax_element(p.begin(), p.end());
    if (!is_solid(t) || *low < 0 || *high >= num_points()) continue;
    const LatticePoint middle{at(p[0]).x / 3 + at(p[1]).x / 3 + at(p[2]).x / 3,
                              at(p[0]).y / 3 + at(p[1]).y / 3 + at(p[2]).y / 3};
    const Eigen::Vector2d relative = (data_.lattice.position(middle) - data_.bounds.min()).cwiseQuotient(size);
    const auto column = std::clamp(static_cast<std::int32_t>(relative.x() * hint_columns_), 0, hint_columns_ - 1);
    const auto row = std::clamp(static_cast<std::int32_t>(relative.y() * hint_rows_), 0, hint_rows_ - 1);
    hints_[row * hint_columns_ + column] = t;
  }
  const auto first = std::find_if(hints_.begin(), hints_.end(), [](TriangleId t) { return t != kNone; });
  if (first == hints_.end()) return hints_.clear();
  TriangleId last = *first;
  for (TriangleId& hint : hints_) {
    if (hint == kNone) hint = last;
    last = hint;
  }
}

TriangleId TriangleMesh::hint_near(const LatticePoint& p) const {
  if (hints_.empty()) return 0;
  const Eigen::Vector2d relative = (data_.lattice.position(p) - data_.bounds.min()).cwiseQuotient(data_.bounds.sizes());
  const double column = std::clamp(relative.x() * hint_columns_, 0.0, hint_columns_ - 1.0);
  const double row = std::clamp(relative.y() * hint_rows_, 0.0, hint_rows_ - 1.0);
  return hints_[static_cast<std::int32_t>(row) * hint_columns_ + static_cast<std::int32_t>(column)];
}

Location TriangleMesh::locate(const LatticePoint& p, TriangleId hint) const {
  if (std::abs(p.x) >= Lattice::kHalfDomain || std::abs(p.y) >= Lattice::kHalfDomain) return {};
  const CurrentMesh view{data_};
  const TriangleId start = hint != kNone ? hint : hint_near(p);
  TriangleId t = walk_to(view, p, start, 4 * static_cast<std::int64_t>(num_triangle_slots()) + 100);
  for (TriangleId s = 0; t == kNone && s < num_triangle_slots(); ++s) {  // the walk ran out of steps: try every slot
    const std::array<PointId, 3>& c = points(s);
    if (orient2d(at(c[0]), at(c[1]), p) >= 0 && orient2d(at(c[1]), at(c[2]), p) >= 0 &&
        orient2d(at(c[2]), at(c[0]), p) >= 0) {
      t = s;
    }
  }
  KERF_CHECK(t != kNone, "the slots tile the domain");

  const std::array<PointId, 3>& corners = points(t);
  for (int k = 0; k < 3; ++k) {
    if (at(corners[k]) == p) return {Location::Kind::kPoint, t, k, corners[k]};
  }
  for (int k = 0; k < 3; ++k) {
    if (orient2d(at(corners[next_corner(k)]), at(corners[previous_corner(k)]), p) != 0) continue;
    const TriangleId other = welded_neighbour(t, k);
    if (other != kNone && other < t) return {Location::Kind::kEdge, other, mirror_corner(t, k), kNone};
    return {Location::Kind::kEdge, t, k, kNone};
  }
  return {Location::Kind::kFace, t, 0, kNone};
}

SegmentWalk TriangleMesh::walk_segment(PointId p, PointId q) const {
  const LatticePoint& from = at(p);
  const LatticePoint& to = at(q);
  SegmentWalk walk;
  std::vector<TriangleId> fan;
  fan_around(p, fan);
  TriangleId t = kNone;
  int k = 0;
  for (const TriangleId s : fan) {
    const int c = corner_of(s, p);
    const PointId right = points(s)[next_corner(c)];
    const PointId left = points(s)[previous_corner(c)];
    if (right == q) return {SegmentWalk::Kind::kEdgeExists, s, previous_corner(c), kNone, {}};
    const int side = orient2d(from, to, at(right));
    if (side == 0 && dot(from, to, from, at(right)) > 0) return {SegmentWalk::Kind::kPoint, s, c, right, {}};
    if (side < 0 && orient2d(from, to, at(left)) > 0) {
      t = s;
      k = c;
    }
  }
  KERF_CHECK(t != kNone, "the fan of a point other than the domain's corners is closed");
  for (;;) {
    if (is_fixed(t, k)) {
      walk.kind = SegmentWalk::Kind::kFixedEdge;
      walk.triangle = t;
      walk.corner = k;
      return walk;
    }
    walk.crossed.push_back({points(t)[next_corner(k)], points(t)[previous_corner(k)]});
    const int mirror = mirror_corner(t, k);
    t = welded_neighbour(t, k);
    const PointId apex = points(t)[mirror];
    if (apex == q) return walk;
    const int side = orient2d(from, to, at(apex));
    if (side == 0) {
      walk.kind = SegmentWalk::Kind::kPoint;
      walk.triangle = t;
      walk.corner = mirror;
      walk.point = apex;
      return walk;
    }
    k = side > 0 ? next_corner(mirror) : previous_corner(mirror);
  }
}

}  // namespace kerf::mesh
