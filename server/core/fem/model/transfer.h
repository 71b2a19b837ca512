#pragma once

#include <span>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/mesh_revert.h"

namespace kerf::fem {

class Model;
struct MassChange;
struct State;

// Carries x and v over edits made one after another, after Model::follow returned `change` for all of them. Every added
// and moved vertex gets the weighted sum of its sources' fields as they were before its edit. A source of weight 1 is
// copied bit for bit. Then the velocities of vertices whose mass changed are shifted by one common vector, so that
// linear momentum is conserved to round-off. Nothing is shifted if the total mass itself changed by more than 1e-9,
// relative: removed material takes its momentum with it. Vertices without material stay where they are, at rest. The
// caller handles pins.
void transfer_state(std::span<const mesh::MeshEdit* const> edits, const Model& model, const MassChange& change,
                    State& state);
void transfer_state(const mesh::MeshEdit& edit, const Model& model, const MassChange& change, State& state);

// Carries a single field over one edit: 3 x V before it, 3 x V after it.
void carry_over(const mesh::MeshEdit& edit, mesh::VertexField& field);

// Carries x and v over edits reverted one after another, after Model::follow returned `change`.
//   - A vertex that remains keeps its position. Copies that merge with it again (lips) do so at the mean of their
//     positions, weighted by mass.
//   - A vertex whose material is restored gets x and v from the adjacent material.
//   - A vertex that got its rest position back gets x and v from that place.
//   - A removed vertex passes its mass and momentum to the vertices that it came from, in the same shares. The rest of
//     the change of masses is compensated as in transfer_state, so linear momentum is conserved to round-off.
// If nothing has moved since the edits were made, positions of vertices that no edit moved are restored bit for bit.
void revert_state(std::span<const mesh::RevertedEdit> reverted, const Model& model, const MassChange& change,
                  State& state);

}  // namespace kerf::fem
