#pragma once

#include "server/core/cut/curve.h"

namespace kerf::cut {

// Returns the parts of the curve inside the box, in order; a stroke that leaves and comes back becomes several. Points
// inside are kept bit for bit. deviation_m grows by the rounding of points where strokes were clipped.
FlatCurve clip(const FlatCurve& curve, const Box& box);

// Returns the number of points that the curve would have if no segment were longer than `spacing` (m, > 0). It is a
// double, so that absurd requests do not overflow.
double spaced_size(const FlatCurve& curve, double spacing);

}  // namespace kerf::cut
