#pragma once

#include <array>
#include <cstddef>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"

namespace kerf::cut {

// Limits of a curve in a request. validate() refuses a curve beyond them, whatever the sheet.
inline constexpr double kMaxCoordinateM = 1.0e4;          // m, largest |x| and |y| of a point, radius and semi-axis
inline constexpr std::size_t kMaxBezierPieces = 64;       // most cubic pieces of one CubicBezier
inline constexpr std::size_t kMaxPolylinePoints = 4096;   // most points of one Polyline
inline constexpr std::size_t kMaxPathSegments = 10'000;   // most segments of all subpaths of one Path together
inline constexpr double kMinWeight = 1.0e-6;              // -, least weight of a control point
inline constexpr double kMaxWeight = 1.0e6;               // -, largest weight of a control point
inline constexpr double kMaxWeightRatio = 1.0e6;          // -, largest ratio of two weights of one segment
inline constexpr double kMaxRotation = 6.28318530717959;  // rad, a full turn either way
inline constexpr std::size_t kMaxPathChords = 200'000;    // most chords that all segments of a Path become together

// A chain of cubic Bezier pieces: piece i has the control points 3i .. 3i+3, so the end of one is the start of the
// next.
struct CubicBezier {
  std::vector<Eigen::Vector2d> points;  // m, material coordinates; 3n + 1 of them, 1 <= n <= kMaxBezierPieces
};

// Straight segments in order. It is closed if the last point equals the first.
struct Polyline {
  std::vector<Eigen::Vector2d> points;  // m, material coordinates; 2 <= count <= kMaxPolylinePoints
};

// A full circle, for punching a hole.
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

// A rational quadratic Bezier segment; a polynomial one if the weights are equal.
struct QuadraticTo {
  Eigen::Vector2d control{0.0, 0.0};             // m
  Eigen::Vector2d end{0.0, 0.0};                 // m
  std::array<double, 3> weights{1.0, 1.0, 1.0};  // -, of start, control and end; kMinWeight..kMaxWeight
};

// A rational cubic Bezier segment; a polynomial one if the weights are equal.
struct CubicTo {
  std::array<Eigen::Vector2d, 2> controls{Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.0, 0.0)};  // m
  Eigen::Vector2d end{0.0, 0.0};                                                                  // m
  std::array<double, 4> weights{1.0, 1.0, 1.0, 1.0};  // -, of start, controls and end; kMinWeight..kMaxWeight
};

// An arc of an ellipse between two points, as in SVG. If the semi-axes are too short to reach both points, they are
// lengthened in proportion. The arc is empty if the points coincide. It is a straight line if a semi-axis would be
// lengthened beyond 1e9 m, as SVG has it for a semi-axis of zero.
struct ArcTo {
  Eigen::Vector2d semi_axes{0.0, 0.0};  // m, each > 0
  double rotation = 0.0;                // rad, from the x axis to the first semi-axis; +-kMaxRotation
  bool large = false;                   // takes the longer way round the ellipse
  bool counter_clockwise = false;       // seen with y up; in SVG, where y points down, this looks clockwise
  Eigen::Vector2d end{0.0, 0.0};        // m
};

using Segment = std::variant<LineTo, QuadraticTo, CubicTo, ArcTo>;

struct Subpath {
  Eigen::Vector2d start{0.0, 0.0};  // m
  std::vector<Segment> segments;    // at least 1
  bool closed = false;              // adds a straight line back to the start, if the end is elsewhere
};

// One or more lines (subpaths), cut at once, each of one or more segments. Corners between segments are kept.
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

// One connected stretch of a flattened curve. It is closed if the last point equals the first, bit for bit.
struct Stroke {
  std::vector<Eigen::Vector2d> points;  // m; at least 2, consecutive ones differ
};

// A curve approximated by polylines.
struct FlatCurve {
  std::vector<Stroke> strokes;
  double deviation_m = 0.0;  // m, proven bound on the distance of curve points from the stroke, and of stroke points
                             // from the curve
};

// Checks a curve without a sheet: numbers are finite and within the limits, and not all points coincide. Errors, all
// kInvalidArgument, with the path of the field ("cut.curve.bezier.points[2].x"): CURVE_NOT_FINITE, CURVE_OUT_OF_RANGE,
// CURVE_TOO_LONG, CURVE_TOO_SHORT, CURVE_DEGENERATE, CURVE_WEIGHT, RADIUS_NOT_POSITIVE.
Status validate(const Curve& curve);

// Turns a valid curve into polylines that keep every end point and every joint of pieces bit for bit.
// `tolerance`: m, > 0; the largest distance allowed between curve and polyline.
// - CubicBezier: uniform subdivision into n chords of the parameter, n from Wang's bound for degree d = 3,
//     distance <= d (d - 1) / 8 * max |second difference of control points| / n^2   (Wang 1984; Farin, "Curves and
//     Surfaces for CAGD", 5th ed., sec. 5.8 gives the second-derivative form).
//   Cusps become points too; a piece has at most 4,096 chords.
// - Circle: inscribed regular polygon, distance = r (1 - cos(pi / n)).
// - Polyline: coincident neighbours are dropped, the rest is kept.
// - Path and Ellipse: see rational_piece.h. Each subpath with two distinct points becomes a stroke. There are at most
//   kMaxPathChords chords in all; the chord farthest from its curve is split first.
//
// If a limit on chords keeps the tolerance from being reached, the returned bound is larger than the tolerance.
FlatCurve flatten(const Curve& curve, double tolerance);

}  // namespace kerf::cut
