#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/step/softening.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/applied_forces.h"
#include "server/core/scene/held_vertices.h"
#include "server/core/scene/lineage.h"
#include "server/core/scene/sheet_materials.h"

namespace kerf::sheet {

// Progress of a sheet through the commands of its scene.
struct SchedulePlace {
  std::int64_t start_tick = 0;  // from which their ticks count
  std::size_t next = 0;         // in their order
};

// Holds all that decides how a sheet moves on, apart from grabs and the tick. A Reset goes back to one, its undo to
// another.
struct Checkpoint {
  mesh::TriangleMesh mesh;
  fem::State state;
  std::vector<mesh::VertexId> pinned;  // sorted, unique
  std::vector<fem::Pin> holds;         // of those, in order
  std::int32_t pins_version = 0;
  std::vector<mesh::VertexId> removed{};  // vertices without material; sorted
  std::shared_ptr<const SheetMaterials> materials;
  std::optional<fem::Softening> softening;
  Wind wind;
  Eigen::Vector3d full_gravity;  // m/s^2
  HeldVertices held_vertices;
  AppliedForces applied_forces;
  Instant now;
  std::int64_t scene_tick = 0;     // ticks since the scene began
  SchedulePlace schedule_place{};  // its start_tick counts from the checkpoint's tick, <= 0
  std::vector<PieceBirth> pieces;
  std::int32_t failed_steps = 0;
  bool frozen = false;
  std::int64_t beginning = 0;  // see CommandReply
};

// Estimates its memory, bytes.
std::size_t bytes_of(const Checkpoint& checkpoint);

}  // namespace kerf::sheet
