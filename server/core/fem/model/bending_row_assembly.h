#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_edge.h"
#include "server/core/fem/element/rest_bending.h"
#include "server/core/fem/element/row_sum.h"
#include "server/core/fem/model/rest_elements.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Sums rows of the bending matrix, one at a time. The row of a vertex is the sum over the patches that contain it, by
// ascending slot, then over such edge terms. Rows thus do not depend on the edits that led to the sheet.
class BendingRowAssembly {
 public:
  struct Terms {
    const RestSheet& sheet;
    std::span<const BendingPatch> patches;       // by slot
    const linear::RowStore<BendingEdge>& edges;  // one row a slot
    std::span<const RestBending> rest;           // by slot; empty for a flat rest shape
  };

  // Makes room for `num_vertices` columns; never shrinks.
  void resize(std::size_t num_vertices) { sum_.resize(num_vertices); }
  // Sets row `vertex` of the bending matrix Q. On a curved rest shape it also sets the row of `bounds`, sums of |Q_ij|
  // + RestBending::excess.
  void set_row(const Terms& terms, mesh::VertexId vertex, linear::RowStore<BendingEntry>& rows,
               linear::RowStore<BendingEntry>& bounds);

 private:
  struct EdgeRow {
    const BendingEdge* edge = nullptr;
    std::size_t place = 0;  // index of the vertex in BendingEdge::vertex
  };
  // Sets patches_ to 8 * slot + row for each patch that contains the vertex, ascending. `row` is the place of the
  // vertex in the patch.
  void find_patches(const RestSheet& sheet, mesh::VertexId vertex);
  // Adds the patches that find_patches() found. entry(slot, a, b) returns entry (a, b) of the matrix of patch `slot`.
  template <typename Entry>
  void add_patches(const Terms& terms, const Entry& entry);
  void add_edges(const Terms& terms, mesh::VertexId vertex);

  // Scratch, of one row.
  std::vector<std::int32_t> found_, patches_;  // unsorted and sorted, see find_patches()
  std::vector<EdgeRow> edges_, edges_sorted_;
  std::vector<std::int32_t> edge_keys_;
  std::vector<std::int32_t> order_;
  RowSum sum_;
};

}  // namespace kerf::fem
