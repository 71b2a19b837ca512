#include "server/core/mesh/build/front_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <queue>
#include <vector>

#include "server/base/interruption.h"
#include "server/core/mesh/lattice_geometry.h"
#include "server/core/mesh/refine/straight_walk.h"
#include "server/core/mesh/triangle_shape.h"

namespace kerf::mesh {
namespace {

using Eigen::Vector2d;

// A triangle is small enough if its circumradius is at most this many times that of an equilateral triangle of the
// wanted size.  -
constexpr double kSmallEnough = 1.3;
// Least distance of a new point from other points (kLeastDistance) and from fixed edges (kLeastHeight), over the size
// wanted there.  -
constexpr double kLeastDistance = 0.6;
constexpr double kLeastHeight = 0.45;
constexpr std::size_t kMaxFrontCavity = 256;

class FrontFill {
 public:
  FrontFill(MeshEditor& editor, const SizeField& sizes) : editor_(editor), mesh_(editor.mesh()), sizes_(sizes) {}

  bool run(std::int64_t max_points) {
    for (TriangleId t = 0; t < mesh_.num_triangle_slots(); ++t) consider(t);
    while (!front_.empty()) {
      interruption_point();
      const Waiting next = front_.top();
      front_.pop();
      if (mesh_.points(next.triangle) != next.points || !advance(next.triangle)) continue;
      if (--max_points < 0) return false;
    }
    return !editor_.budget_exhausted();
  }

 private:
  struct Waiting {
    double excess = 0.0;
    std::int64_t order = 0;
    TriangleId triangle = kNone;
    std::array<PointId, 3> points{};
    friend bool operator<(const Waiting& a, const Waiting& b) {
      if (a.excess != b.excess) return a.excess < b.excess;
      return a.order > b.order;
    }
  };
  // The value of excess() for a slot, valid while its triangle has these corners.
  struct Known {
    std::array<PointId, 3> points{kNone, kNone, kNone};
    double excess = 0.0;
  };

  [[nodiscard]] Vector2d position(PointId p) const { return mesh_.point_position(p); }

  // Returns the circumradius of t over the circumradius of an equilateral triangle of the wanted size.
  double excess(TriangleId t) {
    if (static_cast<std::size_t>(t) >= known_.size())
      known_.resize(static_cast<std::size_t>(mesh_.num_triangle_slots()));
    Known& known = known_[static_cast<std::size_t>(t)];
    const std::array<PointId, 3>& points = mesh_.points(t);
    if (known.points == points) return known.excess;
    known.points = points;
    const std::array<LatticePoint, 3> at = corners_of(mesh_, t);
    const double a = difference(at[1], at[2]).norm();
    const double b = difference(at[2], at[0]).norm();
    const double c = difference(at[0], at[1]).norm();
    const double radius = 0.5 * a * b * c / to_double(doubled_area(at[0], at[1], at[2])) * mesh_.lattice().spacing;
    const Vector2d middle = (position(points[0]) + position(points[1]) + position(points[2])) / 3.0;
    known.excess = radius * std::numbers::sqrt3 / sizes_.at(middle);
    return known.excess;
  }

  [[nodiscard]] bool is_front(TriangleId t, int k) {
    return mesh_.is_fixed(t, k) || excess(mesh_.welded_neighbour(t, k)) <= kSmallEnough;
  }

  void consider(TriangleId t) {
    if (t == kNone || !mesh_.is_solid(t) || excess(t) <= kSmallEnough) return;
    if (is_front(t, 0) || is_front(t, 1) || is_front(t, 2)) front_.push({excess(t), order_++, t, mesh_.points(t)});
  }

  // Inserts a point above one of t's edges at the front: the shortest edge that allows one.
  bool advance(TriangleId t) {
    std::array<int, 3> edges{0, 1, 2};
    std::array<double, 3> squared{};
    for (int k = 0; k < 3; ++k) {
      squared[k] =
          squared_distance(mesh_.at(mesh_.points(t)[next_corner(k)]), mesh_.at(mesh_.points(t)[previous_corner(k)]));
    }
    std::sort(edges.begin(), edges.end(),
              [&](int i, int j) { return std::pair(squared[i], i) < std::pair(squared[j], j); });
    return std::any_of(edges.begin(), edges.end(), [&](int k) { return is_front(t, k) && advance_from(t, k); });
  }

  bool advance_from(TriangleId t, int k) {
    const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
    const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
    const LatticePoint& apex = mesh_.at(mesh_.points(t)[k]);
    const Vector2d edge = difference(a, b), to_apex = difference(a, apex);
    const double length = edge.norm();
    const Vector2d inward = Vector2d(-edge.y(), edge.x()) / length;
    // Height of the circumcentre above the edge. Over the edge length it is (apex - a) . (apex - b) / (2 * doubled
    // area).
    const double circumcentre = length * to_apex.dot(to_apex - edge) / (2.0 * to_double(doubled_area(a, b, apex)));
    if (circumcentre <= 0.0) return false;
    const auto size_at = [&](double height) {
      return sizes_.at(mesh_.lattice().position(rounded(a, 0.5 * edge + height * inward))) / mesh_.lattice().spacing;
    };
    const auto height_for = [&](double size) {
      return std::min(circumcentre, std::sqrt(std::max(size * size - 0.25 * length * length, 0.25 * length * length)));
    };
    const double size = size_at(height_for(size_at(0.5 * length)));
    const LatticePoint target = rounded(a, 0.5 * edge + height_for(size) * inward);
    Location location;
    if (find_wall(mesh_, t, target, location).has_value()) return false;
    if (location.kind != Location::Kind::kFace && location.kind != Location::Kind::kEdge) return false;
    if (!has_room(location.triangle, target, size)) return false;
    const PointId added = editor_.insert_point(target, location.triangle);
    if (added == kNone) return false;
    editor_.legalise(added);
    mesh_.fan_around(added, fan_);
    for (const TriangleId made : fan_) {
      consider(made);
      consider(mesh_.welded_neighbour(made, mesh_.corner_of(made, added)));
    }
    return true;
  }

  // Returns true if a new point at `at` is far enough from points and fixed edges. Checks its cavity: the triangles
  // whose circumcircles contain it. `size`: edge length wanted there, lattice units.
  bool has_room(TriangleId start, const LatticePoint& at, double size) {
    cavity_.assign(1, start);
    for (std::size_t i = 0; i < cavity_.size() && i < kMaxFrontCavity; ++i) {
      const TriangleId t = cavity_[i];
      for (int k = 0; k < 3; ++k) {
        const LatticePoint& p = mesh_.at(mesh_.points(t)[k]);
        if (difference(p, at).norm() < kLeastDistance * size) return false;
        if (!mesh_.is_fixed(t, k)) {
          const TriangleId next = mesh_.welded_neighbour(t, k);
          if (std::find(cavity_.begin(), cavity_.end(), next) == cavity_.end() && mesh_.is_in_circle(next, at))
            cavity_.push_back(next);
          continue;
        }
        const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
        const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
        if (distance_to_segment(at, a, b) < kLeastHeight * size) return false;
      }
    }
    return true;
  }

  MeshEditor& editor_;
  const TriangleMesh& mesh_;
  const SizeField& sizes_;
  std::priority_queue<Waiting> front_;
  std::int64_t order_ = 0;
  std::vector<Known> known_;
  std::vector<TriangleId> cavity_;
  std::vector<TriangleId> fan_;
};

}  // namespace

bool fill_from_border(MeshEditor& editor, const SizeField& sizes, std::int64_t max_points) {
  return FrontFill(editor, sizes).run(max_points);
}

}  // namespace kerf::mesh
