#include "server/core/cut/simplify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "server/core/cut/segment_distance.h"

namespace kerf::cut {

using Eigen::Vector2d;

namespace {

constexpr double kCosCorner = 0.94;  // cos 20 degrees

bool is_corner(const std::vector<Vector2d>& points, std::size_t i) {
  const Vector2d before = points[i] - points[i - 1];
  const Vector2d after = points[i + 1] - points[i];
  return before.dot(after) < kCosCorner * before.norm() * after.norm();
}

}  // namespace

Simplification::Simplification(const std::vector<Vector2d>& points, double flattened, const PathScale& scale)
    : points_(points), flattened_(flattened), kept_(points.size(), false) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Eigen::AlignedBox2d box(points[i].cwiseMin(points[i + 1]), points[i].cwiseMax(points[i + 1]));
    room_.push_back(scale.least_flattening_in(box) - flattened);
    tolerance_.push_back(scale.least_tolerance_in(box));
  }
}

Simplification::Simplification(const std::vector<Vector2d>& points, double flattened, double tolerance)
    : points_(points),
      flattened_(flattened),
      kept_(points.size(), false),
      room_(points.size() - 1, tolerance - flattened),
      tolerance_(points.size() - 1, tolerance) {}

void Simplification::simplify_between_corners() {
  std::size_t from = 0;
  for (std::size_t i = 1; i < points_.size(); ++i) {
    if (i + 1 < points_.size() && !is_corner(points_, i)) continue;
    simplify_stretch(from, i);
    from = i;
  }
}

std::vector<Vector2d> Simplification::kept_points() const {
  std::vector<Vector2d> result;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (kept_[i] && (result.empty() || result.back() != points_[i])) result.push_back(points_[i]);
  }
  return result;
}

void Simplification::simplify_stretch(std::size_t first, std::size_t last) {
  kept_[first] = true;
  std::vector<std::pair<std::size_t, std::size_t>> stack{{first, last}};
  while (!stack.empty()) {
    const auto [a, b] = stack.back();
    stack.pop_back();
    std::size_t worst = a;
    double worst_share = 1.0;
    double moved = 0.0;
    double of_tolerance = 0.0;
    for (std::size_t i = a; i < b; ++i) {
      const double to_start = distance_to_segment(points_[i], points_[a], points_[b]);
      const double to_end = distance_to_segment(points_[i + 1], points_[a], points_[b]);
      const double distance = std::max(to_start, to_end);
      moved = std::max(moved, distance);
      of_tolerance = std::max(of_tolerance, (flattened_ + distance) / tolerance_[i]);
      if (distance <= 0.0 || distance <= worst_share * room_[i]) continue;
      worst_share = room_[i] > 0.0 ? distance / room_[i] : std::numeric_limits<double>::infinity();
      worst = to_start > to_end ? i : i + 1;
    }
    if (worst == a || worst == b) {
      kept_[b] = true;
      moved_ = std::max(moved_, moved);
      of_tolerance_ = std::max(of_tolerance_, of_tolerance);
      continue;
    }
    stack.emplace_back(a, worst);
    stack.emplace_back(worst, b);
  }
}

ScaledCurve simplify(const FlatCurve& curve, const PathScale& scale) {
  if (curve.deviation_m == 0.0 || scale.is_uniform()) return {curve, curve.deviation_m / scale.least_tolerance()};
  ScaledCurve result;
  double moved = 0.0;
  for (const Stroke& stroke : curve.strokes) {
    Simplification simplification(stroke.points, curve.deviation_m, scale);
    simplification.simplify_between_corners();
    result.curve.strokes.push_back({simplification.kept_points()});
    moved = std::max(moved, simplification.moved());
    result.deviation_of_tolerance = std::max(result.deviation_of_tolerance, simplification.of_tolerance());
  }
  result.curve.deviation_m = curve.deviation_m + moved;
  return result;
}

}  // namespace kerf::cut
