#pragma once

#include <vector>

#include "server/core/mesh/build/contour.h"
#include "server/core/mesh/refine/size_field.h"

namespace kerf::mesh {

inline constexpr double kMaxTurnOfEdge = 0.3926990816987242;  // rad, pi / 8; turn of a contour along an edge

// A part of a contour, from one station (m) to a later one.
struct Stretch {
  double from = 0.0, to = 0.0;
};

struct EdgeCounts {
  double least = 1.0;  // the stretch gets at least so many edges
  double most = 0.0;   // more edges than this are a failure
};

// Appends the stations that divide a stretch into edges of the lengths given by `sizes` (m), without the ends of the
// stretch. Edges have equal shares of an integral over the stretch. Its integrand is the larger of 1 / size and turn
// per length / kMaxTurnOfEdge. So edges turn by at most kMaxTurnOfEdge on average. A station very near a point of the
// contour moves to that point, which lies on the true curve. Returns false if more than counts.most edges would be
// needed.
bool divide_stretch(const Contour& contour, const Stretch& stretch, const SizeField& sizes, const EdgeCounts& counts,
                    std::vector<double>& stations);

}  // namespace kerf::mesh
