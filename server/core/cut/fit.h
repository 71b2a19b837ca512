#pragma once

#include "server/base/result.h"
#include "server/core/cut/cut_types.h"

namespace kerf::cut {

// Returns the smallest axis-aligned box around a valid curve. It is found from the ends of pieces and the places where
// x or y has an extremum.
Box extent(const Curve& curve);

// Returns the box by which fit_into() places a curve.
Box frame(const Curve& curve);

// Scales the curve equally in both directions and centres it in the box. If a path begins with two lines that are only
// points, the box that these span is its extent, as of a page. Else its extent then touches two opposite
// sides of the box from inside. `box`: m, each side > 0. Error: kInvalidArgument CURVE_DEGENERATE if both sides of the
// extent are below kMinFitExtentM.
Status fit_into(const Box& box, Curve& curve);

// Moves a curve by a vector, m.
void shift(const Eigen::Vector2d& by, Curve& curve);

}  // namespace kerf::cut
