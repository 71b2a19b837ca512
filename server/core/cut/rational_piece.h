#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/cut/curve.h"

// Rational Bezier segments of degree 1 to 3 in homogeneous coordinates, with the functions that flattening needs.
// Correctly rounded operations only (+ - * / sqrt): the same bits on every machine.
//
// Halving chords until deviation_bound() is small enough proves the distance, for any positive weights:
// - A point of the curve is C(t) = sum l_i(t) p_i with l_i = w_i B_i(t) / sum w_j B_j(t) >= 0, sum l_i = 1.
//   So it is in the convex hull of its control points (Farin, "Curves and Surfaces for CAGD", 5th ed., ch. 13).
//   Subdivision by de Casteljau in homogeneous coordinates keeps weights positive (Lane, Riesenfeld 1980 for the
//   polynomial case).
// - The distance to the chord, a convex set, is a convex function, and zero at both ends, hence
//     dist(C(t)) <= sum over the inner points of l_i(t) dist(p_i) <= max over t of (1 - l_0 - l_n) * max dist(p_i).
//   With u = 1 - B_0 - B_n, in [0, 1 - 2^(1 - n)], W the largest inner weight and w the smaller end weight,
//     1 - l_0 - l_n <= u W / ((1 - u) w + u W), which grows with u: at most k W / (w + k W), k = 2^(n - 1) - 1.
// - Conversely, the curve runs from one end of the chord to the other. So each point of the chord is the foot of a
//   point of the curve, which is no farther than that bound.
namespace kerf::cut {

// A rational Bezier segment. Control point (x, y) with weight w > 0 is stored as (w x, w y, w).
struct RationalPiece {
  int degree = 1;  // 1..3
  std::array<Eigen::Vector3d, 4> points{Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.0, 0.0, 0.0),
                                        Eigen::Vector3d(0.0, 0.0, 0.0),
                                        Eigen::Vector3d(0.0, 0.0, 0.0)};  // the first degree + 1 are used
  Eigen::Vector2d start{0.0, 0.0};  // m; the start as given, since division by its weight would round
  Eigen::Vector2d end{0.0, 0.0};    // m; the end as given
};

RationalPiece piece_of(const Eigen::Vector2d& start, const LineTo& line);
RationalPiece piece_of(const Eigen::Vector2d& start, const QuadraticTo& quadratic);
RationalPiece piece_of(const Eigen::Vector2d& start, const CubicTo& cubic);

Eigen::Vector2d projected(const Eigen::Vector3d& homogeneous);

// Returns both parts of a piece, divided at parameter t in (0, 1).
std::pair<RationalPiece, RationalPiece> split(const RationalPiece& piece, double t);

// Returns the parameter at which a split makes the weights of both ends more equal; 1/2 if they are equal. For
// quadratics, repeated splits bring the weights together as repeated square roots would, whatever they were.
double balanced_parameter(const RationalPiece& piece);

// Returns a proven bound (m) on the distance between piece and chord, both ways (see above), up to rounding.
double deviation_bound(const RationalPiece& piece);

// Returns the parameters in (0, 1), sorted, where the derivative of x (axis 0) or y (axis 1) changes its sign.
std::vector<double> turning_parameters(const RationalPiece& piece, int axis);

// Returns the parameters in (0, 1), sorted, where the derivatives of x and y both vanish: at cusps, and where a curve
// on a straight line turns back.
std::vector<double> cusp_parameters(const RationalPiece& piece);

}  // namespace kerf::cut
