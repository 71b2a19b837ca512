#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/core/fem/element/material.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/command.h"
#include "server/core/scene/lineage.h"
#include "server/core/sheet/done_cut.h"
#include "server/core/sheet/undo_history.h"

namespace kerf::sheet {

// Numbers the applied cuts of a sheet, keeps the family tree of its pieces, and the history for undo and redo.
class CutLog {
 public:
  explicit CutLog(std::int32_t num_pieces) : lineage_(num_pieces) {}

  // Adds cuts that the mesh has made, as one step to undo. Fills in the number and the split pieces of the replies with
  // status kApplied: one for each cut, in order. `mesh`, `x` (3 x V, m): after the cuts. `materials`: by region of it.
  void add(std::vector<DoneCut> cuts, const mesh::TriangleMesh& mesh, const mesh::VertexField& x,
           const std::vector<fem::Material>& materials, std::vector<CutReply>& replies);
  // Notes that the mesh has undone cuts, or made them again.
  void undo(const std::vector<DoneCut>& cuts);
  void redo(const std::vector<DoneCut>& cuts);

  [[nodiscard]] UndoHistory& history() { return history_; }
  [[nodiscard]] const UndoHistory& history() const { return history_; }
  // Cuts applied since the sheet was made, those made again included.
  [[nodiscard]] std::int64_t num_cuts() const { return num_cuts_; }
  [[nodiscard]] const std::vector<PieceBirth>& pieces() const { return lineage_.pieces(); }
  // Goes back to earlier pieces; ids and numbers given since are not given again.
  void restore_pieces(std::vector<PieceBirth> pieces) { lineage_.restore(std::move(pieces)); }

 private:
  UndoHistory history_;
  Lineage lineage_;
  std::int64_t num_cuts_ = 0;
  std::int64_t last_number_ = 0;
};

}  // namespace kerf::sheet
