#pragma once

#include <span>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/mesh_revert.h"

namespace kerf::fem {

class Model;
struct MassChange;
struct State;

// Carries x and v of `state` over edits made one after another. Model::follow has returned `change` for all of them
// together. Every added and moved vertex gets the weighted sum of its sources' fields as they were before its edit. A
// source of weight 1 is copied bit for bit. Then the velocities of vertices whose mass changed are shifted by one
// common vector, so that linear momentum is conserved to round-off. Nothing is shifted if the total mass of these
// vertices changed by more than 1e-9 of itself: removed material takes its momentum with it. Vertices without material
// stay where they are, at rest. The caller handles pins.
void transfer_state(std::span<const mesh::MeshEdit* const> edits, const Model& model, const MassChange& change,
                    State& state);
void transfer_state(const mesh::MeshEdit& edit, const Model& model, const MassChange& change, State& state);

// Carries a single field over one edit: 3 x V before it, 3 x V after it.
void carry_over(const mesh::MeshEdit& edit, linear::VertexField& field);

// Carries x and v of `state` over edits reverted one after another. Model::follow has returned `change` for all of them
// together.
//   - A vertex that remains keeps its position. Copies that merge with it again (lips) do so at the mean of their
//     positions, weighted by mass.
//   - A vertex whose material is restored gets x and v from the adjacent material.
//   - A vertex whose former rest position is back gets x and v from that place of the sheet.
//   - A removed vertex passes its mass and momentum to the vertices that it came from, in the same shares. The rest of
//     the change of masses is compensated as in transfer_state, so linear momentum is conserved to round-off.
// If the sheet has not moved since the edits were made, vertices that no edit moved return to their positions bit for
// bit.
void revert_state(std::span<const mesh::RevertedEdit> reverted, const Model& model, const MassChange& change,
                  State& state);

}  // namespace kerf::fem
