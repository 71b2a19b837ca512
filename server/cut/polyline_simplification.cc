#include "server/cut/polyline_simplification.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double squared_length = along.squaredNorm();
  if (squared_length == 0.0) return (p - a).norm();
  const double t = std::clamp((p - a).dot(along) / squared_length, 0.0, 1.0);
  return (p - a - t * along).norm();
}

}  // namespace

double simplify(const std::vector<Vector2d>& points, double tolerance, std::vector<Vector2d>& kept) {
  kept.clear();
  if (points.empty()) return 0.0;
  std::vector<bool> keeps(points.size());
  keeps.front() = keeps.back() = true;
  double largest = 0.0;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, points.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    double farthest = -1.0;
    std::size_t at = first;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double distance = distance_to_segment(points[i], points[first], points[last]);
      if (distance <= farthest) continue;
      farthest = distance;
      at = i;
    }
    if (at == first) continue;
    if (farthest <= tolerance) {
      largest = std::max(largest, farthest);
      continue;
    }
    keeps[at] = true;
    open.emplace_back(first, at);
    open.emplace_back(at, last);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (keeps[i] && (kept.empty() || kept.back() != points[i])) kept.push_back(points[i]);
  }
  return largest;
}

}  // namespace kerf::cut
