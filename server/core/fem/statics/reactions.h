#pragma once

#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

class Model;
struct Loads;
struct State;

// Forces of the pins on the sheet. `reactions` (3 x V, N) is overwritten, and 0 in all components that no pin holds.
// Forces that a clamp exerts besides them form the couple of the slope it holds, which has no resultant. The force of a
// grab is its own. The reaction includes loads on the pinned vertex itself, such as its weight.

// Finds the reactions at rest at x (3 x V, m): minus elastic forces and loads, without wind. In an equilibrium they
// hold the sheet exactly. In other states they are the forces on the held components if all other components were held
// as well.
void find_reactions(const Model& model, const Loads& loads, const linear::VertexField& x,
                    linear::VertexField& reactions);

// Finds the reactions in motion at the end of a step. They include wind, inertia and the damping of the material, but
// not the damping that the explicit integrator adds for its fastest modes. acceleration: 3 x V, m/s^2, read in held
// components only. It is that of the pins' own motion, 0 for those at rest or at a constant velocity.
void find_reactions(const Model& model, const Loads& loads, const State& state, const linear::VertexField& acceleration,
                    linear::VertexField& reactions);

}  // namespace kerf::fem
