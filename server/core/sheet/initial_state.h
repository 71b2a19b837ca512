#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/ids.h"
#include "server/core/scene/applied_forces.h"
#include "server/core/scene/held_vertices.h"
#include "server/core/scene/mesh_source.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/material_setup.h"

namespace kerf::sheet {

// The state of a sheet at the start, to which a Reset returns.
struct InitialState {
  std::shared_ptr<const scene::SheetConfig> config;
  scene::BuiltMesh built;
  MaterialSetup materials;
  Eigen::Matrix3Xd velocities;         // 3 x V, m/s
  std::vector<mesh::VertexId> pinned;  // vertices of SheetConfig::pins, sorted, unique
  scene::HeldVertices held_vertices;
  scene::AppliedForces applied_forces;
};

// Checks the config, and builds the mesh and all that depends on it. Errors: those of Sheet::create(), except
// SHEET_TOO_STIFF.
Result<InitialState> make_initial_state(scene::SheetConfig config);

}  // namespace kerf::sheet
