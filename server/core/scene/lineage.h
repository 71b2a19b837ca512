#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/material.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/command.h"

// The family tree of a sheet's pieces. The mesh numbers its pieces 0..n-1 and a piece that falls apart keeps its number
// in one of its parts; here each piece has an id of its own. A piece that falls apart ends, and each of its parts is a
// new piece with it as parent. Ids count from 1 and are never given to another piece; those of pieces that an undo took
// away come back only with the redo of that same cut.
namespace kerf::sheet {

// Records the effect of one edit on the tree. Each piece is listed with its number in the mesh.
struct LineageChange {
  std::int32_t num_pieces_before = 0;
  std::int32_t num_pieces_after = 0;                          // those given up still counted
  std::vector<std::pair<std::int32_t, PieceBirth>> ended;     // fell apart
  std::vector<std::pair<std::int32_t, PieceBirth>> born;      // ids consecutive; numbers before any was given up
  std::vector<std::pair<std::int32_t, PieceBirth>> given_up;  // one by one, the highest number taking each over
};

class Lineage {
 public:
  explicit Lineage(std::int32_t num_pieces);

  // By the mesh's piece number.
  [[nodiscard]] const std::vector<PieceBirth>& pieces() const { return pieces_; }

  // Follows an edit made by cut number `cut`; see MeshEdit::split_from and removed_pieces.
  LineageChange split(const std::vector<std::int32_t>& split_from, const std::vector<std::int32_t>& vanished,
                      std::int64_t cut);
  // Undoes the last change that is not undone yet.
  void undo(const LineageChange& change);
  // Makes a change again after its undo.
  void redo(const LineageChange& change);
  // Goes back to the `num_pieces` pieces that the sheet was made with, with their ids of then.
  void reset(std::int32_t num_pieces);
  // Goes back to earlier pieces; ids given since are not given again.
  void restore(std::vector<PieceBirth> pieces) { pieces_ = std::move(pieces); }

 private:
  std::vector<PieceBirth> pieces_;
  std::int64_t next_id_ = 1;
};

// Measures every piece of the mesh; the result is by label. `x`: 3 x V, m. `materials`: by region of the mesh, or one.
// O(slots).
std::vector<Piece> measure_pieces(const mesh::TriangleMesh& mesh, const std::vector<PieceBirth>& births,
                                  const mesh::VertexField& x, const std::vector<fem::Material>& materials);

// Returns, for each change, the pieces that it split or removed, sorted by id. The changes were made one after another;
// `now`: the pieces after the last one.
std::vector<std::vector<SplitPiece>> describe_splits(const std::vector<LineageChange>& changes,
                                                     const std::vector<Piece>& now);

}  // namespace kerf::sheet
