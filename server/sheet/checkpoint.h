#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "server/fem/loads.h"
#include "server/fem/softening.h"
#include "server/fem/state.h"
#include "server/mesh/triangle_mesh.h"
#include "server/sheet/applied_forces.h"
#include "server/sheet/held_vertices.h"
#include "server/sheet/lineage.h"
#include "server/sheet/sheet_materials.h"

namespace kerf::sheet {

// How far a sheet is with the commands of its scene.
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
