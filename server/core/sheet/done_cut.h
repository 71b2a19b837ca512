#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/fem/element/loads.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/scene/lineage.h"

namespace kerf::sheet {

// One applied cut: its effects, and everything needed to undo and redo it.
struct DoneCut {
  mesh::CommittedEdit edit;
  mesh::UndoLog again;  // edit.undo.inverse(): makes the edit again after its undo
  std::int64_t number = 0;
  scene::LineageChange lineage;
  std::vector<fem::Pin> lost_pins;  // pins of vertices that it left without material
  std::int32_t pins_version = 0;    // PinSet::version() at the cut; an undo puts lost_pins back only if it is still the
                                    // same
};

// Returns an estimate of the memory of a cut, bytes.
std::size_t bytes_of(const DoneCut& cut);

std::vector<const mesh::MeshEdit*> edits_of(const std::vector<DoneCut>& cuts);

// Returns the slots below `num_slots` that the cuts rewrote, sorted, unique.
std::vector<mesh::TriangleId> rewritten_slots(const std::vector<DoneCut>& cuts, std::int32_t num_slots);

}  // namespace kerf::sheet
