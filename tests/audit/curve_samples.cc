#include "tests/audit/curve_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <variant>

#include <Eigen/Geometry>

namespace kerf::audit {
namespace {

using Box = Eigen::AlignedBox2d;
using Eigen::Vector2d;

// Evaluates a cubic Bezier curve by de Casteljau's algorithm.
Vector2d bezier_at(const Vector2d* control, double t) {
  std::array<Vector2d, 4> p{control[0], control[1], control[2], control[3]};
  for (std::size_t left = 3; left > 0; --left) {
    for (std::size_t i = 0; i < left; ++i) p[i] += t * (p[i + 1] - p[i]);
  }
  return p[0];
}

// Evaluates a rational Bezier segment by its Bernstein polynomials.
template <std::size_t N>
Vector2d rational_at(const std::array<Vector2d, N>& control, const std::array<double, N>& weights, double t) {
  Vector2d sum(0.0, 0.0);
  double total = 0.0;
  for (std::size_t i = 0; i < N; ++i) {
    const double binomial = i == 0 || i == N - 1 ? 1.0 : static_cast<double>(N - 1);  // degree 2 or 3
    const double share =
        weights[i] * binomial * std::pow(t, static_cast<double>(i)) * std::pow(1.0 - t, static_cast<double>(N - 1 - i));
    sum += share * control[i];
    total += share;
  }
  return sum / total;
}

// Calls `each` with a function that evaluates the segment at t in [0, 1]. Arcs are left out: other tests check them.
template <typename Each>
void sample_segment(const Vector2d& from, const cut::Segment& segment, const Each& each) {
  if (const auto* line = std::get_if<cut::LineTo>(&segment)) {
    each([&](double t) { return Vector2d(from + t * (line->end - from)); });
  } else if (const auto* quadratic = std::get_if<cut::QuadraticTo>(&segment)) {
    each([&](double t) { return rational_at<3>({from, quadratic->control, quadratic->end}, quadratic->weights, t); });
  } else if (const auto* cubic = std::get_if<cut::CubicTo>(&segment)) {
    each([&](double t) {
      return rational_at<4>({from, cubic->controls[0], cubic->controls[1], cubic->end}, cubic->weights, t);
    });
  }
}

// Returns true if the subpath is a single point, where nothing is cut.
bool is_point(const cut::Subpath& subpath) {
  const auto stays = [&](const auto& segment) {
    using Kind = std::decay_t<decltype(segment)>;
    bool same = segment.end == subpath.start;
    if constexpr (std::is_same_v<Kind, cut::QuadraticTo>) same = same && segment.control == subpath.start;
    if constexpr (std::is_same_v<Kind, cut::CubicTo>) {
      same = same && segment.controls[0] == subpath.start && segment.controls[1] == subpath.start;
    }
    return same;
  };
  return std::all_of(subpath.segments.begin(), subpath.segments.end(),
                     [&](const cut::Segment& segment) { return std::visit(stays, segment); });
}

}  // namespace

std::vector<std::vector<Vector2d>> sample_curve(const cut::Curve& curve, int samples, double dust) {
  std::vector<std::vector<Vector2d>> lines;
  const auto each = [&](const auto& at) {
    lines.emplace_back();
    for (int i = 0; i <= samples; ++i) lines.back().push_back(at(static_cast<double>(i) / samples));
  };
  if (const auto* circle = std::get_if<cut::Circle>(&curve)) {
    each([&](double t) {
      const double angle = 2.0 * std::numbers::pi * t;
      return Vector2d(circle->centre + circle->radius * Vector2d(std::cos(angle), std::sin(angle)));
    });
  } else if (const auto* line = std::get_if<cut::Polyline>(&curve)) {
    for (std::size_t i = 0; i + 1 < line->points.size(); ++i) {
      each([&](double t) { return Vector2d(line->points[i] + t * (line->points[i + 1] - line->points[i])); });
    }
  } else if (const auto* bezier = std::get_if<cut::CubicBezier>(&curve)) {
    for (std::size_t i = 0; i + 3 < bezier->points.size(); i += 3) {
      each([&](double t) { return bezier_at(&bezier->points[i], t); });
    }
  } else if (const auto* ellipse = std::get_if<cut::Ellipse>(&curve)) {
    const Eigen::Rotation2Dd rotation(ellipse->rotation);
    each([&](double t) {
      const double angle = 2.0 * std::numbers::pi * t;
      const Vector2d unit(std::cos(angle), std::sin(angle));
      return Vector2d(ellipse->centre + rotation * ellipse->semi_axes.cwiseProduct(unit));
    });
  } else if (const auto* path = std::get_if<cut::Path>(&curve)) {
    for (const cut::Subpath& subpath : path->subpaths) {
      if (is_point(subpath)) continue;
      const std::size_t begin = lines.size();
      Vector2d from = subpath.start;
      for (const cut::Segment& segment : subpath.segments) {
        sample_segment(from, segment, each);
        from = std::visit([](const auto& kind) { return kind.end; }, segment);
      }
      if (subpath.closed) each([&](double t) { return Vector2d(from + t * (subpath.start - from)); });
      Box box;
      for (std::size_t i = begin; i < lines.size(); ++i) {
        for (const Vector2d& point : lines[i]) box.extend(point);
      }
      if (lines.size() > begin && box.diagonal().norm() <= dust) lines.resize(begin);
    }
  }
  return lines;
}

}  // namespace kerf::audit
