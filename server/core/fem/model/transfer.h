#pragma once

#include <span>

#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/mesh_revert.h"

namespace kerf::fem {

// Carries x and v over edits made one after another, after Model::follow returned `change` for all of them: every added
// and moved vertex gets the weighted sum of its sources' fields as they were before its edit (a source of weight 1 is
// copied bit for bit), then the velocities of the vertices whose mass changed are shifted by one common vector so that
// linear momentum is conserved to round-off. Where the total mass itself changed (material removed or added, relative
// change above 1e-9) nothing is shifted: removed material takes its momentum with it. Vertices without material stay
// where they are, at rest. Pins are the caller's business.
void transfer_state(std::span<const mesh::MeshEdit* const> edits, const Model& model, const MassChange& change,
                    State& state);
void transfer_state(const mesh::MeshEdit& edit, const Model& model, const MassChange& change, State& state);

// Carries a field alone over one edit: 3 x V before it, 3 x V after it.
void carry_over(const mesh::MeshEdit& edit, mesh::VertexField& field);

// Carries x and v over edits taken back one after another, after Model::follow returned `change`.
//   - A vertex that remains keeps its position. Copies that become one vertex again with it (lips) do so at the mean of
//     their positions, weighted by mass.
//   - A vertex whose material is back gets x and v from the material that it was next to.
//   - A vertex that got its rest position back gets x and v from where that was.
//   - What a vertex that goes had of mass and momentum goes to the vertices that it came from, in the same shares; the
//     rest of the change of masses is made up for as in transfer_state, so linear momentum is conserved to round-off.
// Where nothing has moved since the edits were made, positions of vertices that no edit moved are what they were bit
// for bit.
void revert_state(std::span<const mesh::RevertedEdit> reverted, const Model& model, const MassChange& change,
                  State& state);

}  // namespace kerf::fem
