#pragma once

#include <cstddef>
#include <vector>

#include "server/base/result.h"
#include "server/core/cut/curve.h"

namespace kerf::cut {

inline constexpr std::size_t kMaxDashLengths = 64;  // entries of a pattern
inline constexpr double kMinDashM = 1.0e-6;         // m, an entry
inline constexpr double kMaxDashM = 1.0e4;          // m, an entry, and the offset either way
inline constexpr double kMaxDashes = 10'000.0;      // dashes that one cut is divided into

// A perforation: lengths that are cut and lengths that are left, in turn, as SVG's stroke-dasharray.
struct DashPattern {
  std::vector<double> lengths;  // m, kMinDashM..kMaxDashM; cut, gap, cut, ... an odd number of them counts twice
  double offset = 0.0;          // m, +-kMaxDashM; how far into the pattern each stroke begins
};

// Errors, kInvalidArgument: DASH_OUT_OF_RANGE ("cut.dash[2]", "cut.dash_offset"), DASH_TOO_LONG ("cut.dash").
Status validate(const DashPattern& pattern);

// Returns the parts of the strokes that are cut, by arc length along the polylines, through their corners. Each stroke
// restarts the pattern at its own start. So does a closed one, whose last dash and first dash meet at the seam if both
// reach it. A pattern without lengths cuts everything. Corners inside dashes are kept bit for bit. Ends of dashes lie
// on their segments up to rounding, by which the bound grows. The bound then holds between each dash and the stretch of
// curve it stands for.
// Error: kResourceExhausted TOO_MANY_DASHES, before anything is made of it.
Result<FlatCurve> dashed(const FlatCurve& curve, const DashPattern& pattern);

}  // namespace kerf::cut
