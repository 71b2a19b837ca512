#pragma once

#include <cstdint>
#include <vector>

#include "server/base/result.h"
#include "server/cut/path_scale.h"

namespace kerf::cut {

// Pairs of chords so close that the strips around them may overlap; work and memory for the outline grow with them.
inline constexpr std::int64_t kMaxStripPairs = 300'000;

// The border of a strip: closed strokes with the strip on their left, so those around holes run clockwise, that neither
// cross themselves nor each other, but for rounding.
struct Outline {
  FlatCurve curve;                      // its bound: no point of the strip is farther than half the width plus that
                                        // from the curve, and all closer than half the width minus that are in it
  double deviation_of_tolerance = 0.0;  // -; the same over the tolerance there, the largest of all places
  double area_m2 = 0.0;                 // m^2, of the strip
};

// The outline of the strip of `width` (m) around a curve flattened to half of what the tolerance leaves. Offsetting and
// union by the library Clipper (Vatti 1992, "A generic solution to polygon clipping"), on a grid of its own.
// Error: kResourceExhausted WIDTH_WORK_BUDGET, before anything is made of it: more than kMaxStripPairs.
Result<Outline> outline(const FlatCurve& curve, double width, const PathScale& scale);

// Whether `at` (m) is inside the outline, by its winding number. O(points of the outline).
bool contains(const std::vector<Stroke>& outline, const Eigen::Vector2d& at);

}  // namespace kerf::cut
