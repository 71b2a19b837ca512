#include "client/load/cut_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf::load {
namespace {

// Shows a triangle within a ring.
constexpr const char* kDrawing =
    R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 40"><g fill="none" stroke="black">)"
    R"(<circle cx="20" cy="20" r="19"/><path d="M 20 8 L 30 27 L 10 27 Z"/></g></svg>)";
constexpr int kPoints = 5;       // Outer corners of a star.
constexpr double kInner = 0.45;  // Radius of the inner corners, as a share of the outer ones.

// Adds the point `along` the direction of the cut and `across` it, m. `Line`: a message with points.
template <typename Line>
void add_point(const CutPlace& place, double along, double across, Line& line) {
  v1::Vec2& point = *line.add_points();
  point.set_x(place.x + along * std::cos(place.angle) - across * std::sin(place.angle));
  point.set_y(place.y + along * std::sin(place.angle) + across * std::cos(place.angle));
}

void add_star(const CutPlace& place, v1::Polyline& line) {
  for (int i = 0; i <= 2 * kPoints; ++i) {
    if (i == 2 * kPoints) {
      *line.add_points() = line.points(0);  // Closed, to the last bit.
      return;
    }
    const double radius = 0.5 * place.length * (i % 2 == 0 ? 1.0 : kInner);
    const double angle = std::numbers::pi * i / kPoints;
    add_point(place, radius * std::cos(angle), radius * std::sin(angle), line);
  }
}

}  // namespace

std::string_view name_of(CutKind kind) {
  return std::find_if(kCutKinds.begin(), kCutKinds.end(), [kind](const auto& each) { return each.second == kind; })
      ->first;
}

v1::Cut cut_of(CutKind kind, std::int64_t k, const CutPlace& place) {
  v1::Cut cut;
  v1::Curve& curve = *cut.mutable_curve();
  const double half = 0.5 * place.length;
  switch (kind) {
    case CutKind::kSlit:
      add_point(place, -half, 0.0, *curve.mutable_polyline());
      add_point(place, half, 0.0, *curve.mutable_polyline());
      break;
    case CutKind::kCurve:  // An S: to one side, then to the other.
      for (const auto& [along, across] : {std::pair(-1.0, 0.0), {-0.3, 0.8}, {0.3, -0.8}, {1.0, 0.0}}) {
        add_point(place, half * along, half * across, *curve.mutable_bezier());
      }
      break;
    case CutKind::kCircle:
      curve.mutable_circle()->mutable_center()->set_x(place.x);
      curve.mutable_circle()->mutable_center()->set_y(place.y);
      curve.mutable_circle()->set_radius_m(half);
      break;
    case CutKind::kStar:
      add_star(place, *curve.mutable_polyline());
      break;
    case CutKind::kDrawing: {
      curve.mutable_svg()->set_text(kDrawing);
      v1::MaterialBox& box = *cut.mutable_fit();
      box.mutable_min()->set_x(place.x - half);
      box.mutable_min()->set_y(place.y - half);
      box.mutable_max()->set_x(place.x + half);
      box.mutable_max()->set_y(place.y + half);
      break;
    }
    case CutKind::kMixed:
      return cut_of(kCutKinds[static_cast<std::size_t>(k) % (kCutKinds.size() - 1)].second, k, place);
  }
  return cut;
}

}  // namespace kerf::load
