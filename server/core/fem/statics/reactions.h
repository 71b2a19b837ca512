#pragma once

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// What the pins do to the sheet: `reactions` (3 x V, N), overwritten, 0 in all components that no pin holds. What a
// clamp does beside them is the couple of the slope it holds, which has no resultant; what a grab does is its own
// force. A pin's part of a load that acts on its own vertex, its weight among them, goes into it at once, and belongs
// to it.

// At rest at x (3 x V, m): minus elastic forces and loads, without wind. Exactly what holds the sheet in an
// equilibrium; elsewhere what would hold the held components, were the others held too.
void find_reactions(const Model& model, const Loads& loads, const mesh::VertexField& x, mesh::VertexField& reactions);

// In motion at the end of a step, with the damping of the material (its own, not what the explicit integrator adds for
// its fastest modes), wind and inertia. acceleration: 3 x V, m/s^2, read in held components alone: that of the pins'
// own motion, 0 for those at rest or at a constant velocity.
void find_reactions(const Model& model, const Loads& loads, const State& state, const mesh::VertexField& acceleration,
                    mesh::VertexField& reactions);

}  // namespace kerf::fem
