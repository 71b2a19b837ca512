#pragma once

#include <array>
#include <span>

#include "server/core/fem/element/angle_bending.h"
#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_edge.h"
#include "server/core/fem/model/border_clamps.h"
#include "server/core/fem/model/rest_elements.h"
#include "server/core/linear/row_store.h"

namespace kerf::fem {

// Assembles bending by angles for a sheet that is flat at rest. `patches`, the rows of `edges` and the three `sides` of
// each patch are by slot. O(V).
AngleBending make_angle_bending(const RestSheet& sheet, const BorderClamps& clamps,
                                std::span<const BendingPatch> patches, const linear::RowStore<BendingEdge>& edges,
                                std::span<const std::array<BendingSide, 3>> sides);

}  // namespace kerf::fem
