#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/base/phase_observer.h"
#include "server/base/result.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/element/material.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/done_cut.h"
#include "server/core/sheet/grab_set.h"
#include "server/core/sheet/pin_set.h"

namespace kerf::sheet {

// The parts of a sheet, apart from the mesh, that cuts need, as they are before the cuts.
struct CutSurroundings {
  std::int32_t max_vertices = 0;  // most vertices that the mesh may have
  const PinSet& pins;
  const GrabSet& grabs;
  const linear::VertexField& positions;                      // 3 x V, m, world
  const std::vector<fem::Material>& materials;               // by region of the mesh
  std::optional<cut::ShiftLimit> most_shift = std::nullopt;  // absent if the sheet may pass through itself
  std::span<const scene::ComponentPlace> components = {};
};

struct MeshCuts {
  std::vector<scene::CutReply> replies;  // replies to all cuts; number and split pieces are not set yet
  std::vector<DoneCut> done;             // the applied cuts; number and lineage are not set yet
};

// Cuts only the mesh, one cut after another. If a cut is refused, the mesh returns to its state before all cuts.
// Errors: those of scene::place(), cut::plan() and cut::apply(); with `is_batch` they name the cut.
Result<MeshCuts> cut_mesh(std::span<const scene::Cut> cuts, bool is_batch, const CutSurroundings& around,
                          mesh::TriangleMesh& mesh, PhaseObserver* observer);

}  // namespace kerf::sheet
