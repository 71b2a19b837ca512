#pragma once

#include "server/fem/model.h"
#include "server/fem/state.h"
#include "server/mesh/mesh_edit.h"

namespace kerf::fem {

// Carries x and v over an edit, after Model::apply(mesh, edit) returned `change`: every added and moved vertex gets the
// weighted sum of its sources' fields as they were (a source of weight 1 is copied bit for bit), then the velocities of
// the vertices whose mass changed are shifted by one common vector so that linear momentum is conserved to round-off.
// Where the total mass itself changed (material removed or added, relative change above 1e-9) nothing is shifted:
// removed material takes its momentum with it. Pins are the caller's business.
void transfer_state(const mesh::MeshEdit& edit, const Model& model, const MassChange& change, State& state);

}  // namespace kerf::fem
