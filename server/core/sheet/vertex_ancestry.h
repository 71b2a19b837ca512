#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "server/core/mesh/ids.h"
#include "server/core/sheet/done_cut.h"

namespace kerf::sheet {

// Traces vertices that cuts made as copies of others back to the vertices from before the cuts.
class VertexAncestry {
 public:
  // `cuts`: one or more, in the order in which they were made.
  explicit VertexAncestry(const std::vector<DoneCut>& cuts);

  // Returns true if the cuts made the vertex, so that their undo removes it.
  [[nodiscard]] bool is_new(mesh::VertexId v) const { return v >= num_vertices_; }
  // Returns v itself if it existed before the cuts. Otherwise returns the vertex from before the cuts of which it is a
  // copy, directly or through other copies. Returns kNone for a vertex at a point that the cuts made.
  [[nodiscard]] mesh::VertexId ancestor(mesh::VertexId v) const;

 private:
  std::int32_t num_vertices_;                                       // number of vertices before the cuts
  std::unordered_map<mesh::VertexId, mesh::VertexId> copied_from_;  // looked up, never iterated
};

}  // namespace kerf::sheet
