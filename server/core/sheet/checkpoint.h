#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/fem/element/state.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/lineage.h"
#include "server/core/sheet/material_setup.h"
#include "server/core/sheet/pin_set.h"
#include "server/core/sheet/scene_clock.h"
#include "server/core/sheet/sheet_conditions.h"

namespace kerf::sheet {

// All that decides how a MovingSheet moves on, apart from grabs.
struct MovingState {
  mesh::TriangleMesh mesh;
  fem::State state;
  PinSet pins;
  std::vector<mesh::VertexId> removed{};  // vertices without material; sorted
  MaterialSetup materials;
  ConditionValues conditions;
  std::int32_t failed_steps = 0;
  bool is_frozen = false;
};

// Holds all that decides how a sheet moves on, apart from grabs and the tick. A Reset goes back to one, its undo to
// another.
struct Checkpoint {
  MovingState moving;
  ScenePlace place;
  std::vector<PieceBirth> pieces;
  std::int64_t beginning = 0;  // see CommandReply
};

// Estimates its memory, bytes.
std::size_t bytes_of(const Checkpoint& checkpoint);

}  // namespace kerf::sheet
