#pragma once

#include <array>
#include <cstddef>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"

namespace kerf::cut {

// Limits on what a request may hold. Beyond them a curve is refused, whatever the sheet.
inline constexpr double kMaxCoordinateM = 1.0e4;          // m, |x| and |y| of every point, radii and semi-axes
inline constexpr std::size_t kMaxBezierPieces = 64;       // cubic pieces in one CubicBezier
inline constexpr std::size_t kMaxPolylinePoints = 4096;   // points in one Polyline
inline constexpr std::size_t kMaxPathSegments = 10'000;   // segments in all subpaths of one Path together
inline constexpr double kMinWeight = 1.0e-6;              // -, of a control point
inline constexpr double kMaxWeight = 1.0e6;               // -
inline constexpr double kMaxWeightRatio = 1.0e6;          // -, largest weight of a segment / its smallest
inline constexpr double kMaxRotation = 6.28318530717959;  // rad, a full turn either way
inline constexpr std::size_t kMaxPathChords = 200'000;    // chords all curved segments of a Path become together

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

// A full ellipse.
struct Ellipse {
  Eigen::Vector2d centre{0.0, 0.0};     // m, material coordinates
  Eigen::Vector2d semi_axes{0.0, 0.0};  // m, each > 0
  double rotation = 0.0;                // rad, from the x axis to the first semi-axis; +-kMaxRotation
};

// Segments of a path. Each starts where the one before it ended.
struct LineTo {
  Eigen::Vector2d end{0.0, 0.0};  // m
};

// A rational quadratic Bezier segment; the polynomial one where the weights are equal.
struct QuadraticTo {
  Eigen::Vector2d control{0.0, 0.0};             // m
  Eigen::Vector2d end{0.0, 0.0};                 // m
  std::array<double, 3> weights{1.0, 1.0, 1.0};  // -, of start, control and end; kMinWeight..kMaxWeight
};

// A rational cubic Bezier segment; the polynomial one where the weights are equal.
struct CubicTo {
  std::array<Eigen::Vector2d, 2> controls{Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.0, 0.0)};  // m
  Eigen::Vector2d end{0.0, 0.0};                                                                  // m
  std::array<double, 4> weights{1.0, 1.0, 1.0, 1.0};  // -, of start, controls and end; kMinWeight..kMaxWeight
};

// An arc of an ellipse between two points, as SVG has it: semi-axes too short for the distance of the points are
// lengthened in proportion until they reach. The arc is nothing if the points coincide. A semi-axis so short that the
// other would be lengthened beyond 1e9 m counts as zero, which makes a straight line, as in SVG.
struct ArcTo {
  Eigen::Vector2d semi_axes{0.0, 0.0};  // m, each > 0
  double rotation = 0.0;                // rad, from the x axis to the first semi-axis; +-kMaxRotation
  bool large = false;                   // the longer way round the ellipse
  bool counter_clockwise = false;       // with y up; where y points down, as in SVG's own frame, it looks clockwise
  Eigen::Vector2d end{0.0, 0.0};        // m
};

using Segment = std::variant<LineTo, QuadraticTo, CubicTo, ArcTo>;

struct Subpath {
  Eigen::Vector2d start{0.0, 0.0};  // m
  std::vector<Segment> segments;    // at least 1
  bool closed = false;              // ends with a straight line back to the start, unless it is there already
};

// Any number of lines cut at once, each of any number of segments, whose corners are kept.
struct Path {
  std::vector<Subpath> subpaths;  // at least 1; at most kMaxPathSegments segments in all
};

// An axis-aligned box in material coordinates.  m
struct Box {
  Eigen::Vector2d low{0.0, 0.0};
  Eigen::Vector2d high{0.0, 0.0};

  [[nodiscard]] bool contains(const Eigen::Vector2d& point) const {
    return (point.array() >= low.array()).all() && (point.array() <= high.array()).all();
  }
};

// A curve drawn by a client, in material coordinates. flatten() turns each alternative into Strokes; later stages do
// not distinguish them.
using Curve = std::variant<CubicBezier, Polyline, Circle, Ellipse, Path>;

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
// CURVE_TOO_SHORT, CURVE_DEGENERATE, CURVE_WEIGHT, RADIUS_NOT_POSITIVE.
Status validate(const Curve& curve);

// Turns a valid curve into polylines that keep every end point and every joint of pieces bit for bit.
// `tolerance`: m, > 0; the largest distance allowed between curve and polyline.
// CubicBezier: uniform subdivision into n chords of the parameter, n from Wang's bound for degree d = 3,
//   distance <= d (d - 1) / 8 * max |second difference of control points| / n^2   (Wang 1984; Farin, "Curves and
//   Surfaces for CAGD", 5th ed., sec. 5.8 gives the second-derivative form),
// with cusps added as points; at most 4,096 chords a piece. Circles: inscribed regular polygons, distance =
// r (1 - cos(pi / n)). Polylines: coincident neighbours are dropped, the rest is kept.
// Paths and ellipses: see rational_piece.h; one stroke for each subpath that has two distinct points. At most
// kMaxPathChords chords in all, the farthest from its curve being split first.
// If a limit on chords keeps the tolerance from being reached, the returned bound is larger than the tolerance.
FlatCurve flatten(const Curve& curve, double tolerance);

}  // namespace kerf::cut
