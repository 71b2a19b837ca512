#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/material.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/command.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

// The family tree of a sheet's pieces. The mesh numbers its pieces 0..n-1 ("labels"), and if a piece falls apart, one
// part keeps its label. Here each piece has an id as well. A piece that falls apart ends, and each of its parts is a
// new piece with the old one as parent. Ids count from 1 and never name another piece. If an undo removes pieces, only
// the redo of the same cut brings their ids back.
namespace kerf::scene {

// The effect of one edit on the tree. Each piece is listed with its label.
struct LineageChange {
  std::int32_t num_pieces_before = 0;
  std::int32_t num_pieces_after = 0;                          // after splits, before labels are given up
  std::vector<std::pair<std::int32_t, PieceBirth>> ended;     // pieces that fell apart
  std::vector<std::pair<std::int32_t, PieceBirth>> born;      // new pieces, with consecutive ids; labels as before any
                                                              // is given up
  std::vector<std::pair<std::int32_t, PieceBirth>> given_up;  // removed pieces, in order; the piece with the highest
                                                              // label takes each label
};

class Lineage {
 public:
  explicit Lineage(std::int32_t num_pieces);

  // Returns all pieces, by label.
  [[nodiscard]] const std::vector<PieceBirth>& pieces() const { return pieces_; }

  // Follows an edit made by cut number `cut`. `split_from`, `vanished`: MeshEdit::split_from and removed_pieces.
  LineageChange split(const std::vector<std::int32_t>& split_from, const std::vector<std::int32_t>& vanished,
                      std::int64_t cut);
  // Undoes the last change that is not undone yet.
  void undo(const LineageChange& change);
  // Makes a change again after its undo.
  void redo(const LineageChange& change);
  // Returns to the `num_pieces` pieces of the sheet as made, with their ids 1..num_pieces.
  void reset(std::int32_t num_pieces);
  // Returns to earlier pieces. Ids used since then are not used again.
  void restore(std::vector<PieceBirth> pieces) { pieces_ = std::move(pieces); }

 private:
  friend struct Fields<Lineage>;
  std::vector<PieceBirth> pieces_;
  std::int64_t next_id_ = 1;
};

// Measures all pieces of the mesh; the result is by label. `births`: by label. `x`: present positions, 3 x V, m.
// `materials`: by region of the mesh, or a single one. O(slots).
std::vector<Piece> measure_pieces(const mesh::TriangleMesh& mesh, const std::vector<PieceBirth>& births,
                                  const linear::VertexField& x, const std::vector<fem::Material>& materials);

// Returns, for each change, the pieces that it split or removed, sorted by id. The changes were made one after another;
// `now`: the pieces after the last one.
std::vector<std::vector<SplitPiece>> describe_splits(const std::vector<LineageChange>& changes,
                                                     const std::vector<Piece>& now);

}  // namespace kerf::scene
