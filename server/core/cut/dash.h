#pragma once

#include "server/base/result.h"
#include "server/core/cut/cut_types.h"

namespace kerf::cut {

// Returns the parts of the strokes that are cut, by arc length along the polylines, through their corners. Each stroke
// restarts the pattern at its own start. So does a closed one, whose last dash and first dash meet at the seam if both
// reach it. A pattern without lengths cuts everything. Corners inside dashes are kept bit for bit. Ends of dashes lie
// on their segments up to rounding, by which the bound grows. The bound then holds between each dash and the stretch of
// curve it stands for.
// Error: kResourceExhausted TOO_MANY_DASHES, before anything is made of it.
Result<FlatCurve> dashed(const FlatCurve& curve, const DashPattern& pattern);

}  // namespace kerf::cut
