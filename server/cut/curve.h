#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"

namespace kerf::cut {

// Limits on what a request may hold. Beyond them a curve is refused, whatever the sheet.
inline constexpr double kMaxCoordinateM = 1.0e4;         // m, |x| and |y| of every point and the radius
inline constexpr std::size_t kMaxBezierPieces = 64;      // cubic pieces in one curve
inline constexpr std::size_t kMaxPolylinePoints = 4096;  // points in one curve

// A chain of cubic Bezier pieces: piece i has the control points 3i .. 3i+3, so the end of one is the start of the
// next.
struct CubicBezier {
  std::vector<Eigen::Vector2d> points;  // m, material coordinates; 3n + 1 of them, 1 <= n <= kMaxBezierPieces
};

// Straight segments in order. Closed where the last point equals the first.
struct Polyline {
  std::vector<Eigen::Vector2d> points;  // m, material coordinates; 2 <= count <= kMaxPolylinePoints
};

// A full circle: a punch.
struct Circle {
  Eigen::Vector2d centre{0.0, 0.0};  // m, material coordinates
  double radius = 0.0;               // m, > 0
};

// What a client draws, in material coordinates. Each alternative is turned into Strokes by flatten(); nothing behind
// that function knows which it was.
using Curve = std::variant<CubicBezier, Polyline, Circle>;

// One connected stretch of a flattened curve. Closed where the last point equals the first, bit for bit.
struct Stroke {
  std::vector<Eigen::Vector2d> points;  // m; at least 2, consecutive ones differ
};

// A curve as polylines.
struct FlatCurve {
  std::vector<Stroke> strokes;
  double deviation_m = 0.0;  // proven: no point of the curve is farther than this from its stroke, nor the other way
};

// Checks a curve by itself: finite, inside the limits, more than one distinct point. Errors, all kInvalidArgument, with
// the path of the field ("cut.curve.bezier.points[2].x"): CURVE_NOT_FINITE, CURVE_OUT_OF_RANGE, CURVE_TOO_LONG,
// CURVE_TOO_SHORT, CURVE_DEGENERATE, RADIUS_NOT_POSITIVE.
Status validate(const Curve& curve);

// Turns a valid curve into polylines that keep every end point and every joint of pieces bit for bit.
// `tolerance`: m, > 0; the largest distance allowed between curve and polyline.
// Beziers: uniform subdivision into n chords of the parameter, n from Wang's bound for degree d = 3,
//   distance <= d (d - 1) / 8 * max |second difference of control points| / n^2   (Wang 1984; Farin, "Curves and
//   Surfaces for CAGD", 5th ed., sec. 5.8 gives the second-derivative form),
// with cusps added as points. Circles: inscribed regular polygons, distance = r (1 - cos(pi / n)).
// Polylines: coincident neighbours are dropped, the rest is kept.
// At most 4,096 chords a piece; where that does not reach the tolerance the achieved bound is larger and returned so.
FlatCurve flatten(const Curve& curve, double tolerance);

}  // namespace kerf::cut
