#include "server/service/dxf/shapes_of.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "server/core/cut/arc.h"
#include "server/service/dxf/spline.h"

namespace kerf::dxf {
namespace {

using Eigen::Vector2d;

constexpr int kClosed = 1;
constexpr int kFrameVertex = 16;  // A vertex of the frame of a polyline that is a spline.
constexpr int kMeshOrFaces = 16 | 64;
constexpr double kTurn = 2.0 * std::numbers::pi;

struct BulgedPoint {
  Vector2d at;
  double bulge = 0.0;  // Tangent of a quarter of the angle of the arc to the next point.
};

// Appends a straight line or the arc of a bulge to `line`, from `from` to `to`.
void append_bulged(const Vector2d& from, double bulge, const Vector2d& to, cut::Subpath& line) {
  const double chord = (to - from).norm();
  if (bulge == 0.0 || chord == 0.0) {
    if (chord > 0.0) line.segments.emplace_back(cut::LineTo{to});
    return;
  }
  const double radius = chord * (1.0 + bulge * bulge) / (4.0 * std::abs(bulge));
  line.segments.emplace_back(cut::ArcTo{{radius, radius}, 0.0, std::abs(bulge) > 1.0, bulge > 0.0, to});
}

std::vector<cut::Subpath> polyline_through(const std::vector<BulgedPoint>& points, bool closed) {
  if (points.size() < 2) return {};
  cut::Subpath line{points.front().at, {}, closed};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    append_bulged(points[i].at, points[i].bulge, points[i + 1].at, line);
  }
  if (closed) append_bulged(points.back().at, points.back().bulge, points.front().at, line);
  if (line.segments.empty()) return {};
  return {line};
}

std::vector<cut::Subpath> light_polyline(const Entity& entity) {
  std::vector<BulgedPoint> points;
  for (const Group* group = entity.first; group != entity.last; ++group) {
    const double value =
        group->code == 10 || group->code == 20 || group->code == 42 ? to_number(group->value).value_or(0.0) : 0.0;
    if (group->code == 10) points.push_back({{value, 0.0}});
    if (points.empty()) continue;
    if (group->code == 20) points.back().at.y() = value;
    if (group->code == 42) points.back().bulge = value;
  }
  return polyline_through(points, (entity.integer(70, 0) & kClosed) != 0);
}

std::vector<cut::Subpath> heavy_polyline(const Entity& entity, const std::vector<Entity>& vertices) {
  std::vector<BulgedPoint> points;
  for (const Entity& vertex : vertices) {
    if ((vertex.integer(70, 0) & kFrameVertex) != 0) continue;
    points.push_back({vertex.point(10), vertex.number(42, 0.0)});
  }
  return polyline_through(points, (entity.integer(70, 0) & kClosed) != 0);
}

// Returns an arc of centre + cos(t) a + sin(t) b from the angle `from` (rad) over `sweep` > 0, in exact pieces of at
// most a quarter.
cut::Subpath elliptic_arc(const Vector2d& centre, const Vector2d& a, const Vector2d& b, double from, double sweep) {
  const bool is_whole = sweep >= kTurn - 1e-12;
  const int count = std::max(1, static_cast<int>(std::ceil(std::min(sweep, kTurn) / (0.25 * kTurn) - 1e-9)));
  const auto direction = [&](int i) { return cut::unit_vector(from + sweep * i / count); };
  const auto place = [&](const Vector2d& unit) -> Vector2d { return centre + unit.x() * a + unit.y() * b; };
  Vector2d u = direction(0);
  cut::Subpath line{place(u), {}, is_whole};
  for (int i = 1; i <= count; ++i) {
    const Vector2d v = direction(i);
    const double cosine = u.dot(v);
    const Vector2d end = is_whole && i == count ? line.start : place(v);
    line.segments.emplace_back(
        cut::QuadraticTo{place((u + v) / (1.0 + cosine)), end, {1.0, std::sqrt(0.5 * (1.0 + cosine)), 1.0}});
    u = v;
  }
  return line;
}

// Returns an angle, rad, moved into (0, 2 pi].
double full_turn_or_less(double angle) {
  if (!(std::abs(angle) < 1e6)) return kTurn;
  angle -= kTurn * std::floor(angle / kTurn);
  return angle < 1e-9 ? kTurn : angle;
}

std::vector<cut::Subpath> arc(const Entity& entity) {
  const double radius = entity.number(40, 0.0);
  if (!(radius > 0.0)) return {};
  const bool is_circle = entity.type == "CIRCLE";
  const double from = is_circle ? 0.0 : entity.number(50, 0.0) * kTurn / 360.0;
  const double to = is_circle ? kTurn : entity.number(51, 360.0) * kTurn / 360.0;
  if (!(std::abs(from) < 1e3)) return {};
  return {elliptic_arc(entity.point(10), {radius, 0.0}, {0.0, radius}, from, full_turn_or_less(to - from))};
}

std::vector<cut::Subpath> ellipse(const Entity& entity) {
  const Vector2d major = entity.point(11);
  const double ratio = entity.number(40, 1.0);
  if (!(major.norm() > 0.0) || !(ratio > 0.0)) return {};
  const double side = plane_of(entity) == Plane::kMirrored ? -ratio : ratio;
  const double from = entity.number(41, 0.0);
  if (!(std::abs(from) < 1e3)) return {};
  return {elliptic_arc(entity.point(10), major, side * Vector2d(-major.y(), major.x()), from,
                       full_turn_or_less(entity.number(42, kTurn) - from))};
}

std::vector<cut::Subpath> spline(const Entity& entity) {
  Spline spline;
  spline.degree = entity.integer(71, 3);
  std::vector<Vector2d> fitted;
  for (const Group* group = entity.first; group != entity.last; ++group) {
    const double value = group->code >= 10 && group->code < 80 ? to_number(group->value).value_or(0.0) : 0.0;
    if (group->code == 40) spline.knots.push_back(value);
    if (group->code == 41) spline.weights.push_back(value);
    if (group->code == 10) spline.points.emplace_back(value, 0.0);
    if (group->code == 20 && !spline.points.empty()) spline.points.back().y() = value;
    if (group->code == 11) fitted.emplace_back(value, 0.0);
    if (group->code == 21 && !fitted.empty()) fitted.back().y() = value;
  }
  if (is_valid(spline)) return {segments_of(spline)};
  if (fitted.size() < 2) return {};
  const bool closed = (entity.integer(70, 0) & kClosed) != 0;
  if (closed && fitted.front() != fitted.back()) fitted.push_back(fitted.front());
  return {through_points(fitted)};
}

std::vector<cut::Subpath> line_between(const Vector2d& from, const Vector2d& to) {
  if (from == to) return {};
  return {{from, {cut::LineTo{to}}, false}};
}

}  // namespace

Plane plane_of(const Entity& entity) {
  const double z = entity.number(230, 1.0);
  const double across = Vector2d(entity.number(210, 0.0), entity.number(220, 0.0)).norm();
  if (!(across <= 1e-6 * std::abs(z))) return Plane::kOther;
  return z > 0.0 ? Plane::kUpright : Plane::kMirrored;
}

bool has_own_plane(std::string_view type) {
  return type != "LINE" && type != "ELLIPSE" && type != "SPLINE";
}

std::optional<std::vector<cut::Subpath>> outline_of(const Entity& entity, const std::vector<Entity>& vertices) {
  if (entity.type == "LINE") return line_between(entity.point(10), entity.point(11));
  if (entity.type == "LWPOLYLINE") return light_polyline(entity);
  if (entity.type == "POLYLINE" && (entity.integer(70, 0) & kMeshOrFaces) == 0) return heavy_polyline(entity, vertices);
  if (entity.type == "CIRCLE" || entity.type == "ARC") return arc(entity);
  if (entity.type == "ELLIPSE") return ellipse(entity);
  if (entity.type == "SPLINE") return spline(entity);
  return std::nullopt;
}

}  // namespace kerf::dxf
