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

// Everything that determines how a MovingSheet continues to move, except grabs.
struct MovingState {
  mesh::TriangleMesh mesh;
  fem::State state;
  PinSet pins;
  std::vector<mesh::VertexId> removed{};  // vertices without material; sorted
  MaterialSetup materials;
  ConditionValues conditions;
  scene::SelfContact self_contact;
  std::int32_t failed_steps = 0;
  bool is_frozen = false;
};

// Everything that determines how a sheet continues, except grabs and the tick. A Reset restores the checkpoint of the
// start; its undo restores that before the Reset.
struct Checkpoint {
  MovingState moving;
  ScenePlace place;
  std::vector<scene::PieceBirth> pieces;
  std::int64_t beginning = 0;  // see CommandReply::beginning
};

// Returns an estimate of the memory of a checkpoint, bytes.
std::size_t bytes_of(const Checkpoint& checkpoint);

}  // namespace kerf::sheet
