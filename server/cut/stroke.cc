#include "server/cut/stroke.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

// Bound on the distance from a point a + t (b - a), as computed, to the segment ab.
double interpolation_error(const Vector2d& a, const Vector2d& b) {
  const double largest = std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
  return 8.0 * std::numeric_limits<double>::epsilon() * largest;
}

// The range of t in [0, 1] for which a + t (b - a) is inside the box (Liang and Barsky 1984).
std::optional<std::pair<double, double>> inside_range(const Vector2d& a, const Vector2d& b, const Box& box) {
  double enter = 0.0;
  double leave = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    const double step = b[axis] - a[axis];
    double low = box.low[axis] - a[axis];
    double high = box.high[axis] - a[axis];
    if (step == 0.0) {
      if (low > 0.0 || high < 0.0) return std::nullopt;
      continue;
    }
    if (step < 0.0) std::swap(low, high);
    enter = std::max(enter, low / step);
    leave = std::min(leave, high / step);
  }
  if (!(enter < leave)) return std::nullopt;
  return std::make_pair(enter, leave);
}

}  // namespace

FlatCurve clip(const FlatCurve& curve, const Box& box) {
  FlatCurve result;
  double rounding = 0.0;
  Stroke current;
  const auto finish = [&] {
    if (current.points.size() >= 2) result.strokes.push_back(std::move(current));
    current = Stroke{};
  };
  for (const Stroke& stroke : curve.strokes) {
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      const Vector2d& a = stroke.points[i];
      const Vector2d& b = stroke.points[i + 1];
      const bool a_inside = box.contains(a);
      const bool b_inside = box.contains(b);
      const auto range = inside_range(a, b, box);
      if (!range) {
        finish();
        continue;
      }
      if (!a_inside) finish();
      if (!a_inside || !b_inside) rounding = std::max(rounding, interpolation_error(a, b));
      const Vector2d start = a_inside ? a : Vector2d(a + range->first * (b - a));
      const Vector2d end = b_inside ? b : Vector2d(a + range->second * (b - a));
      if (current.points.empty()) current.points.push_back(start);
      if (current.points.back() != end) current.points.push_back(end);
      if (!b_inside) finish();
    }
    finish();
  }
  result.deviation_m = curve.deviation_m + rounding;
  return result;
}

double spaced_size(const FlatCurve& curve, double spacing) {
  double size = 0.0;
  for (const Stroke& stroke : curve.strokes) {
    size += 1.0;
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      size += std::max(1.0, std::ceil((stroke.points[i + 1] - stroke.points[i]).norm() / spacing));
    }
  }
  return size;
}

}  // namespace kerf::cut
