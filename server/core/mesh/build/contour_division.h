#pragma once

#include <vector>

#include "server/core/mesh/build/contour.h"
#include "server/core/mesh/refine/size_field.h"

namespace kerf::mesh {

inline constexpr double kMaxTurnOfEdge = 0.3926990816987242;  // rad, pi / 8

// A part of a contour between two of its stations.  m
struct Stretch {
  double from = 0.0, to = 0.0;
};

struct EdgeCounts {
  double least = 1.0;  // parts to make in any case
  double most = 0.0;   // parts beyond which none are made
};

// Appends the stations that divide a stretch into parts of the lengths given by `sizes` (m). Parts are equal in the
// integral of 1 / size or of turn / kMaxTurnOfEdge, whichever is larger at each place. So on average they turn by at
// most kMaxTurnOfEdge. The ends of the stretch are left out. Returns false if that takes more than counts.most parts.
// Stations go to points of the contour that are very near: those lie on the curve that it stands for.
bool divide_stretch(const Contour& contour, const Stretch& stretch, const SizeField& sizes, const EdgeCounts& counts,
                    std::vector<double>& stations);

}  // namespace kerf::mesh
