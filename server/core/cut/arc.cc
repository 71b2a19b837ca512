#include "server/core/cut/arc.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kQuarterTurn = 1.57079632679489661923;  // rad

// Largest length (m) to which a semi-axis may be lengthened.
constexpr double kMaxSemiAxisM = 1.0e9;

// Turns a vector counter-clockwise by `quarters` times 90 degrees, exactly.
Vector2d turned(const Vector2d& v, int quarters) {
  switch (quarters & 3) {
    case 0:
      return v;
    case 1:
      return {-v.y(), v.x()};
    case 2:
      return -v;
    default:
      return {v.y(), -v.x()};
  }
}

// Returns (cos, sin) for |angle| up to little more than an eighth of a turn. The 13th term of either series is below
// 1e-17.
Vector2d series(double angle) {
  const double square = angle * angle;
  double cosine = 0.0;
  double sine = 0.0;
  for (int i = 13; i > 0; --i) {
    cosine = 1.0 - square / ((2.0 * i - 1.0) * (2.0 * i)) * (i == 13 ? 1.0 : cosine);
    sine = 1.0 - square / ((2.0 * i) * (2.0 * i + 1.0)) * (i == 13 ? 1.0 : sine);
  }
  return {cosine, angle * sine};
}

// Maps the plane so that the unit circle becomes the ellipse.
struct EllipseFrame {
  Vector2d centre;
  Vector2d semi_axes;
  Vector2d direction;  // unit vector along the first semi-axis

  [[nodiscard]] Vector2d operator()(const Vector2d& unit) const {
    const Vector2d scaled = semi_axes.cwiseProduct(unit);
    return centre + Vector2d(direction.x() * scaled.x() - direction.y() * scaled.y(),
                             direction.y() * scaled.x() + direction.x() * scaled.y());
  }
};

// Makes the part of the ellipse that is the image of the unit arc from u to v. These are unit vectors at most 90
// degrees apart, up to rounding. `end`: the image of v as it is to be stored, bit for bit.
QuadraticTo unit_arc(const EllipseFrame& frame, const Vector2d& u, const Vector2d& v, const Vector2d& end) {
  const double cosine = u.dot(v);
  return {frame((u + v) / (1.0 + cosine)), end, {1.0, std::sqrt(0.5 * (1.0 + cosine)), 1.0}};
}

double reach(const EllipseFrame& frame) {
  return frame.centre.cwiseAbs().maxCoeff() + 2.0 * frame.semi_axes.maxCoeff();
}

// Returns true if one piece can go from u to v, both unit vectors: the angle in the direction `turn` (+-1) is at most
// 90 degrees. Rounding may make it slightly negative. Angles above 180 degrees are not allowed.
bool within_quarter(const Vector2d& u, const Vector2d& v, int turn) {
  const double cross = turn * (u.x() * v.y() - u.y() * v.x());
  const double cosine = u.dot(v);
  return cosine > 0.5 || (cross >= 0.0 && cosine >= -1.0e-6);
}

}  // namespace

Vector2d unit_vector(double angle_rad) {
  const double quarters = std::round(angle_rad / kQuarterTurn);
  return turned(series(angle_rad - quarters * kQuarterTurn), static_cast<int>(quarters));
}

Vector2d unit_vector_of_degrees(double angle_deg) {
  const double reduced = std::fmod(angle_deg, 360.0);  // exact, as is the next difference
  const double quarters = std::round(reduced / 90.0);
  return turned(series((reduced - 90.0 * quarters) * (kQuarterTurn / 90.0)), static_cast<int>(quarters));
}

EllipsePieces ellipse_pieces(const Ellipse& ellipse) {
  const EllipseFrame frame{ellipse.centre, ellipse.semi_axes, unit_vector(ellipse.rotation)};
  EllipsePieces result;
  const Vector2d unit(1.0, 0.0);
  result.start = frame(unit);
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Vector2d u = turned(unit, quarter);
    const Vector2d v = turned(unit, quarter + 1);
    result.quarters.segments.push_back(unit_arc(frame, u, v, quarter == 3 ? result.start : frame(v)));
  }
  result.quarters.rounding_m = 32.0 * kEpsilon * reach(frame);
  return result;
}

ArcPieces arc_pieces(const Vector2d& start, const ArcTo& arc) {
  ArcPieces result;
  if (start == arc.end) return result;
  EllipseFrame frame{{0.0, 0.0}, arc.semi_axes, unit_vector(arc.rotation)};
  // Half the chord from start to end, in coordinates in which the ellipse is the unit circle.
  const Vector2d half = 0.5 * (start - arc.end);
  const Vector2d along(frame.direction.x() * half.x() + frame.direction.y() * half.y(),
                       frame.direction.x() * half.y() - frame.direction.y() * half.x());
  Vector2d p = along.cwiseQuotient(frame.semi_axes);
  double length = p.norm();
  const bool lengthened = length > 1.0 + 8.0 * kEpsilon;
  if (!(length <= 1.0)) {  // also true for NaN (0 / 0)
    if (!(length * frame.semi_axes.maxCoeff() <= kMaxSemiAxisM)) {
      result.segments.push_back({0.5 * start + 0.5 * arc.end, arc.end, {1.0, 1.0, 1.0}});
      return result;
    }
    frame.semi_axes *= length;
    p /= length;
    length = 1.0;
  }
  // Distance of the centre from the chord. It is the root of a rounded difference, so inaccurate if the chord is nearly
  // a diameter.
  const double across = std::sqrt(std::max(0.0, (1.0 - length) * (1.0 + length)));
  const double side = arc.large != arc.counter_clockwise ? across : -across;
  const Vector2d c = length > 0.0 ? Vector2d(Vector2d(p.y(), -p.x()) * (side / length)) : Vector2d(0.0, -side);
  const Vector2d u = (p - c).normalized();
  const Vector2d v = (-p - c).normalized();
  const Vector2d middle = 0.5 * start + 0.5 * arc.end;
  frame.centre = middle;
  frame.centre = frame(c);

  const int turn = arc.counter_clockwise ? 1 : -1;
  const int at_least = arc.large ? 2 : 0;  // whole quarters to make first; after them at most half a turn is left
  Vector2d from = u;
  for (int quarter = 0; quarter < at_least || (quarter < at_least + 2 && !within_quarter(from, v, turn)); ++quarter) {
    const Vector2d to = turned(from, turn);
    result.segments.push_back(unit_arc(frame, from, to, frame(to)));
    from = to;
  }
  result.segments.push_back(unit_arc(frame, from, v, arc.end));
  const double ill = lengthened ? 0.0 : 8.0 * kEpsilon / std::max(across, std::sqrt(8.0 * kEpsilon));
  result.rounding_m = 64.0 * kEpsilon * reach(frame) + ill * frame.semi_axes.maxCoeff();
  return result;
}

}  // namespace kerf::cut
