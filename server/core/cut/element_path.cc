#include "server/core/cut/element_path.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "server/base/check.h"
#include "server/base/elementary.h"

namespace kerf::cut {

using Eigen::Vector2d;
using mesh::kNone;
using mesh::LatticePoint;
using mesh::next_corner;
using mesh::previous_corner;
using mesh::TriangleId;

namespace {

constexpr int kMaxSegmentTriangles = 1'000'000;  // most triangles that one segment may run through

// Divides one stroke at the edges of the mesh.
class Crossings {
 public:
  Crossings(const mesh::TriangleMesh& mesh, const Stroke& stroke) : mesh_(mesh) {
    points_.push_back(stroke.points.front());
    at_ = mesh_.lattice().nearest(points_.front());
    triangle_ = mesh_.locate(at_).triangle;
    KERF_CHECK(triangle_ != kNone, "a clipped path stays inside the domain");
    kept_.push_back(0);
    for (std::size_t i = 1; i < stroke.points.size(); ++i) {
      follow(stroke.points[i]);
      points_.push_back(stroke.points[i]);
    }
    if (kept_.back() + 1 != points_.size()) keep_here(kNone);
  }

  [[nodiscard]] const std::vector<Vector2d>& points() const { return points_; }
  // Returns the indices of the points that end chords, ascending.
  [[nodiscard]] std::vector<std::size_t> kept() const {
    std::vector<std::size_t> kept = kept_;
    kept.insert(kept.end(), bends_.begin(), bends_.end());
    std::sort(kept.begin(), kept.end());
    return kept;
  }

 private:
  // Continues the path straight to `to`, and adds the crossings with edges on the way.
  void follow(const Vector2d& to) {
    const LatticePoint target = mesh_.lattice().nearest(to);
    TriangleId previous = kNone;
    for (int step = 0; step < kMaxSegmentTriangles; ++step) {
      int exit = kNone;
      for (int k = 0; k < 3 && exit == kNone; ++k) {
        const LatticePoint& right = mesh_.at(mesh_.points(triangle_)[next_corner(k)]);
        const LatticePoint& left = mesh_.at(mesh_.points(triangle_)[previous_corner(k)]);
        if (mesh_.welded_neighbour(triangle_, k) == previous || mesh::orient2d(right, left, target) >= 0) continue;
        if (mesh::orient2d(at_, target, right) <= 0 && mesh::orient2d(at_, target, left) >= 0) exit = k;
      }
      if (exit == kNone) break;
      const LatticePoint& right = mesh_.at(mesh_.points(triangle_)[next_corner(exit)]);
      const LatticePoint& left = mesh_.at(mesh_.points(triangle_)[previous_corner(exit)]);
      const LatticePoint crossing = mesh::rounded_crossing(right, left, at_, target);
      points_.push_back(mesh_.lattice().position(crossing));
      keep_here(exit);
      previous = triangle_;
      triangle_ = mesh_.welded_neighbour(triangle_, exit);
    }
    at_ = target;
  }

  // Ends a chord at the last point. `exit`: the edge of triangle_ on which that point lies; kNone: it lies inside.
  void keep_here(int exit) {
    const std::size_t first = kept_.back();
    const std::size_t last = points_.size() - 1;
    if (entry_ != kNone && exit != kNone && is_longer_than_midline(first, last, exit)) keep_sharpest_bend(first, last);
    kept_.push_back(last);
    entry_ = exit == kNone ? kNone : mesh_.mirror_corner(triangle_, exit);
  }

  [[nodiscard]] bool is_longer_than_midline(std::size_t first, std::size_t last, int exit) const {
    const auto middle = [this](int k) -> Vector2d {
      return 0.5 * (mesh_.point_position(mesh_.points(triangle_)[next_corner(k)]) +
                    mesh_.point_position(mesh_.points(triangle_)[previous_corner(k)]));
    };
    return (points_[last] - points_[first]).norm() > (middle(exit) - middle(entry_)).norm();
  }

  // Keeps the point of largest curvature strictly between two points of the curve, if the curve bends there.
  void keep_sharpest_bend(std::size_t first, std::size_t last) {
    std::size_t sharpest = first;
    double largest = 0.0;
    for (std::size_t i = first + 1; i < last; ++i) {
      const Vector2d before = points_[i] - points_[i - 1];
      const Vector2d after = points_[i + 1] - points_[i];
      const double turn = std::abs(arc_tangent(before.x() * after.y() - before.y() * after.x(), before.dot(after)));
      const double curvature = 2.0 * turn / (before.norm() + after.norm());
      if (curvature <= largest) continue;
      largest = curvature;
      sharpest = i;
    }
    if (sharpest != first) bends_.push_back(sharpest);
  }

  const mesh::TriangleMesh& mesh_;
  std::vector<Vector2d> points_;
  std::vector<std::size_t> kept_;   // indices of the ends of chords
  std::vector<std::size_t> bends_;  // indices of the points of largest curvature that were added
  LatticePoint at_;
  TriangleId triangle_ = kNone;
  int entry_ = kNone;  // the edge by which the path entered triangle_
};

}  // namespace

ScaledCurve element_path(const mesh::TriangleMesh& mesh, const FlatCurve& curve, const PathScale& scale) {
  ScaledCurve result;
  // Crossings are rounded to the lattice, by half a unit in x and in y.
  const double flattened = curve.deviation_m + mesh.lattice().spacing;
  double moved = 0.0;
  for (const Stroke& stroke : curve.strokes) {
    const Crossings crossings(mesh, stroke);
    if (curve.deviation_m == 0.0) {
      Stroke all{crossings.points()};
      all.points.erase(std::unique(all.points.begin(), all.points.end()), all.points.end());
      result.curve.strokes.push_back(std::move(all));
      continue;
    }
    Simplification simplification(crossings.points(), flattened, scale);
    const std::vector<std::size_t> kept = crossings.kept();
    for (std::size_t i = 0; i + 1 < kept.size(); ++i) simplification.simplify_stretch(kept[i], kept[i + 1]);
    result.curve.strokes.push_back({simplification.kept_points()});
    moved = std::max(moved, simplification.moved());
    result.deviation_of_tolerance = std::max(result.deviation_of_tolerance, simplification.of_tolerance());
  }
  result.curve.deviation_m = flattened + moved;
  result.deviation_of_tolerance = std::max(result.deviation_of_tolerance, flattened / scale.least_tolerance());
  return result;
}

}  // namespace kerf::cut
