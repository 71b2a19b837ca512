#include "server/core/cut/stroke.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

// Returns a bound on the distance from the computed point a + t (b - a) to the segment ab.
double interpolation_error(const Vector2d& a, const Vector2d& b) {
  const double largest = std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
  return 8.0 * std::numeric_limits<double>::epsilon() * largest;
}

// Returns the range of t in [0, 1] for which a + t (b - a) is inside the box (Liang and Barsky 1984).
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

// Collects the part of a curve that lies in a box, segment by segment.
class Clipper {
 public:
  explicit Clipper(const Box& box) : box_(box) {}

  void add_segment(const Vector2d& a, const Vector2d& b) {
    const bool a_inside = box_.contains(a);
    const bool b_inside = box_.contains(b);
    const auto range = inside_range(a, b, box_);
    if (!range) return end_stroke();
    if (!a_inside) end_stroke();
    if (!a_inside || !b_inside) rounding_ = std::max(rounding_, interpolation_error(a, b));
    const Vector2d start = a_inside ? a : Vector2d(a + range->first * (b - a));
    const Vector2d end = b_inside ? b : Vector2d(a + range->second * (b - a));
    if (current_.points.empty()) current_.points.push_back(start);
    if (current_.points.back() != end) current_.points.push_back(end);
    if (!b_inside) end_stroke();
  }
  void end_stroke() {
    if (current_.points.size() >= 2) strokes_.push_back(std::move(current_));
    current_ = Stroke{};
  }

  // Returns a bound on the distance (m) of clipped ends from their segments.
  [[nodiscard]] double rounding() const { return rounding_; }
  [[nodiscard]] std::vector<Stroke> take_strokes() { return std::move(strokes_); }

 private:
  const Box& box_;
  std::vector<Stroke> strokes_;
  Stroke current_;
  double rounding_ = 0.0;
};

}  // namespace

FlatCurve clip(const FlatCurve& curve, const Box& box) {
  Clipper clipper(box);
  for (const Stroke& stroke : curve.strokes) {
    for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
      clipper.add_segment(stroke.points[i], stroke.points[i + 1]);
    }
    clipper.end_stroke();
  }
  FlatCurve result;
  result.strokes = clipper.take_strokes();
  result.deviation_m = curve.deviation_m + clipper.rounding();
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
