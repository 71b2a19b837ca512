#pragma once

#include "server/base/result.h"
#include "server/core/cut/cut_types.h"

namespace kerf::cut {

// Returns the dashes: the parts of the strokes that are cut, measured by arc length along the polylines. Each stroke
// starts the pattern again. So does a closed one: its last and first dash touch at the seam if both reach it. A pattern
// without lengths cuts everything. Corners inside dashes are kept bit for bit. Ends of dashes lie on their segments up
// to rounding, which is added to deviation_m. The result's deviation_m bounds the distance between each dash and its
// stretch of the curve.
// Error: kResourceExhausted TOO_MANY_DASHES, found before any dash is made.
Result<FlatCurve> dashed(const FlatCurve& curve, const DashPattern& pattern);

}  // namespace kerf::cut
