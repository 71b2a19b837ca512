#pragma once

#include "server/base/result.h"
#include "server/core/cut/cut_types.h"

namespace kerf::cut {

// Returns the smallest axis-aligned box around a valid curve, from its ends and the places at which its pieces turn
// back in x or y.
Box extent(const Curve& curve);

// Scales the curve equally in both directions and centres it in the box. Its extent then touches two opposite sides of
// the box from inside. `box`: m, each side > 0. Error: CURVE_DEGENERATE where the extent is below kMinFitExtentM.
Status fit_into(const Box& box, Curve& curve);

}  // namespace kerf::cut
