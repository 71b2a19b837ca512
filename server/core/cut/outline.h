#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"

namespace kerf::cut {

// Most pairs of chords that are so close that the strips around them may overlap. Work and memory for the outline grow
// with their number.
inline constexpr std::int64_t kMaxStripPairs = 300'000;
// Most points of the outlines of single chords, summed over both chords of all such pairs. A point costs 0.1 to 0.2 us.
inline constexpr std::int64_t kMaxStripPoints = 5'000'000;

// The border of a strip: closed strokes with the strip on their left, so those around holes run clockwise. Up to
// rounding, they cross neither themselves nor each other.
struct Outline {
  FlatCurve curve;  // deviation_m: points of the strip are at most half the width plus this from the curve. All points
                    // closer than half the width minus this are in the strip
  double area_m2 = 0.0;  // m^2, of the strip
};

// Makes the outline of the strip of `width` (m) around a flattened curve. `tolerance`: m, > 0; most that this adds to
// deviation_m of the curve, apart from rounding. The library Clipper offsets and unites chords (Vatti 1992, "A generic
// solution to polygon clipping"), on a grid of its own.
// Error: kResourceExhausted WIDTH_WORK_BUDGET, found before any work: more than kMaxStripPairs or kMaxStripPoints.
Result<Outline> outline(const FlatCurve& curve, double width, double tolerance);

// Returns true if `at` (m) is inside the outline, by its winding number. O(points of the outline).
bool contains(const std::vector<Stroke>& outline, const Eigen::Vector2d& at);

}  // namespace kerf::cut
