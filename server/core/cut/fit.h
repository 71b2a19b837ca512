#pragma once

#include <optional>

#include "server/base/result.h"
#include "server/core/cut/box.h"
#include "server/core/cut/curve.h"

namespace kerf::cut {

// Target placement of a curve, independent of its own size and place.
struct Fit {
  std::optional<Box>
      box;  // m, each side > 0; absent: the sheet's bounding box less kFitMargin of each side at each end
};

inline constexpr double kFitMargin = 0.05;        // -
inline constexpr double kMinFitExtentM = 1.0e-9;  // m, of the larger side of a curve that is fitted

// Errors, kInvalidArgument: FIT_OUT_OF_RANGE, FIT_EMPTY ("cut.fit.max.x").
Status validate(const Fit& fit);

// Returns the smallest axis-aligned box around a valid curve, from its ends and the places at which its pieces turn
// back in x or y.
Box extent(const Curve& curve);

// Scales the curve equally in both directions and centres it in the box. Its extent then touches two opposite sides of
// the box from inside. `box`: m, each side > 0. Error: CURVE_DEGENERATE where the extent is below kMinFitExtentM.
Status fit_into(const Box& box, Curve& curve);

}  // namespace kerf::cut
