#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/cut/curve.h"

// Ellipses and their arcs as rational quadratic Bezier segments, which represent them exactly (Farin, "Curves and
// Surfaces for CAGD", 5th ed., ch. 12). An arc of the unit circle lies between unit vectors u and v at most 90 degrees
// apart. Its control point is (u + v) / (1 + u.v), its weights are 1, sqrt((1 + u.v) / 2), 1.
namespace kerf::cut {

// (cos, sin) of an angle, good to a few units in the last place, by the Taylor series on an eighth of a turn: rounded
// operations only, so that it has the same bits on every machine, unlike the library's sine and cosine. Exact at
// multiples of 90 degrees.
Eigen::Vector2d unit_vector(double angle_rad);             // |angle| <= 1e3
Eigen::Vector2d unit_vector_of_degrees(double angle_deg);  // finite

struct ArcPieces {
  std::vector<QuadraticTo> segments;  // the last ends where the arc does, bit for bit
  double rounding_m = 0.0;            // m; bound on the distance between the pieces and the requested arc
};

// Four quarters, counter-clockwise from `start`, the end of the first semi-axis.
struct EllipsePieces {
  Eigen::Vector2d start{0.0, 0.0};
  ArcPieces quarters;
};
EllipsePieces ellipse_pieces(const Ellipse& ellipse);

// At most five pieces of at most 90 degrees; none where start and end coincide. The centre is that of SVG 1.1, appendix
// F.6.5, found in the frame in which the ellipse is the unit circle. `arc`: finite, semi-axes > 0.
ArcPieces arc_pieces(const Eigen::Vector2d& start, const ArcTo& arc);

}  // namespace kerf::cut
