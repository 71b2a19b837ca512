#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"

namespace kerf::cut {

// Pairs of chords so close that the strips around them may overlap; work and memory for the outline grow with them.
inline constexpr std::int64_t kMaxStripPairs = 300'000;
// Points of the outlines around the two chords of each such pair, summed over all pairs, before outlines are united. A
// point costs 0.1 to 0.2 us.
inline constexpr std::int64_t kMaxStripPoints = 5'000'000;

// The border of a strip: closed strokes with the strip on their left, so those around holes run clockwise. Up to
// rounding, they cross neither themselves nor each other.
struct Outline {
  FlatCurve curve;  // its bound: no point of the strip is farther from the curve than half the width plus the bound.
                    // All points closer than half the width minus the bound are in it
  double area_m2 = 0.0;  // m^2, of the strip
};

// Makes the outline of the strip of `width` (m) around a flattened curve. `tolerance`: m, > 0; largest addition to the
// bound, apart from rounding. Offsetting and union by the library Clipper (Vatti 1992, "A generic solution to polygon
// clipping"), on a grid of its own.
// Error: kResourceExhausted WIDTH_WORK_BUDGET, before anything is made of it: more than kMaxStripPairs, or
// kMaxStripPoints.
Result<Outline> outline(const FlatCurve& curve, double width, double tolerance);

// Returns true if `at` (m) is inside the outline, by its winding number. O(points of the outline).
bool contains(const std::vector<Stroke>& outline, const Eigen::Vector2d& at);

}  // namespace kerf::cut
