#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/cut/curve.h"

// Ellipses and their arcs as rational quadratic Bezier segments, which represent them exactly (Farin, "Curves and
// Surfaces for CAGD", 5th ed., ch. 12). An arc of the unit circle lies between unit vectors u and v at most 90 degrees
// apart. Its control point is (u + v) / (1 + u.v), its weights are 1, sqrt((1 + u.v) / 2), 1.
namespace kerf::cut {

// Return (cos, sin) of an angle, correct to a few units in the last place. They sum Taylor series over at most an
// eighth of a turn, with correctly rounded operations only. So every machine gets the same bits, unlike with the
// library's sine and cosine. Multiples of 90 degrees are exact.
Eigen::Vector2d unit_vector(double angle_rad);             // |angle_rad| <= 1e3
Eigen::Vector2d unit_vector_of_degrees(double angle_deg);  // any finite angle

struct ArcPieces {
  std::vector<QuadraticTo> segments;  // the last one ends at the end of the arc, bit for bit
  double rounding_m = 0.0;            // m; bound on the distance between the pieces and the requested arc
};

// An ellipse as four quarters, counter-clockwise. `start` is the end of the first semi-axis.
struct EllipsePieces {
  Eigen::Vector2d start{0.0, 0.0};
  ArcPieces quarters;
};
EllipsePieces ellipse_pieces(const Ellipse& ellipse);

// Returns an arc as at most five pieces of at most 90 degrees; none if start and end coincide. The centre is that of
// SVG 1.1, appendix F.6.5, computed in coordinates in which the ellipse is the unit circle. `arc`: finite, semi-axes >
// 0.
ArcPieces arc_pieces(const Eigen::Vector2d& start, const ArcTo& arc);

}  // namespace kerf::cut
