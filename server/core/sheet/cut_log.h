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

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// Numbers the applied cuts of a sheet. Keeps the family tree of its pieces and the history for undo and redo.
class CutLog {
 public:
  explicit CutLog(std::int32_t num_pieces) : lineage_(num_pieces) {}

  // Adds cuts that the mesh has made, as one undo step. Sets number and split pieces of the replies with status
  // kApplied, of which there is one for each cut, in order. `mesh`, `x` (3 x V, m): after the cuts. `materials`: by
  // region of the mesh.
  void add(std::vector<DoneCut> cuts, const mesh::TriangleMesh& mesh, const linear::VertexField& x,
           const std::vector<fem::Material>& materials, std::vector<scene::CutReply>& replies);
  // Must be called after the mesh has undone these cuts, or made them again.
  void undo(const std::vector<DoneCut>& cuts);
  void redo(const std::vector<DoneCut>& cuts);

  [[nodiscard]] UndoHistory& history() { return history_; }
  [[nodiscard]] const UndoHistory& history() const { return history_; }
  // Returns the number of cuts applied since the sheet was made; a redo counts again.
  [[nodiscard]] std::int64_t num_cuts() const { return num_cuts_; }
  [[nodiscard]] const std::vector<scene::PieceBirth>& pieces() const { return lineage_.pieces(); }
  // Returns to earlier pieces. Ids and numbers used since then are not used again.
  void restore_pieces(std::vector<scene::PieceBirth> pieces) { lineage_.restore(std::move(pieces)); }

 private:
  friend struct Fields<CutLog>;
  UndoHistory history_;
  scene::Lineage lineage_;
  std::int64_t num_cuts_ = 0;
  std::int64_t last_number_ = 0;
};

}  // namespace kerf::sheet
