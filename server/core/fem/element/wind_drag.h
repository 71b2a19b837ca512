#pragma once

#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/fem/element/state.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Returns true if the air exerts drag.
[[nodiscard]] bool has_wind_drag(const Wind& wind);

// Adds the air drag at x (3 x V, m) and v (3 x V, m/s) to f (3 x V, N); see Wind. `materials` have the mass per area at
// rest. The force acts over a kick of `duration` (s). The drag rate r of each triangle, 1/s, is divided by sqrt(1 + (r
// duration)^2), so that the kick cannot carry it past the velocity of the air. Slots are processed in order.
void add_wind_drag(std::span<const ElementBlock> blocks, const MaterialTable& materials, const Wind& wind,
                   double duration, const State& state, linear::VertexField& f);

}  // namespace kerf::fem
