#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "server/core/mesh/ids.h"
#include "server/core/sheet/done_cut.h"

namespace kerf::sheet {

// Traces vertices that cuts made, as copies of others, back to the vertices that were there before the cuts.
class VertexAncestry {
 public:
  // `cuts`: one or more, in the order of their making.
  explicit VertexAncestry(const std::vector<DoneCut>& cuts);

  // Returns true if the cuts made the vertex, so that an undo of them takes it away.
  [[nodiscard]] bool is_new(mesh::VertexId v) const { return v >= num_vertices_; }
  // Returns the vertex that was there before the cuts: v itself, or the one that v is a copy of, directly or through
  // others. kNone for a vertex at a point that the cuts made.
  [[nodiscard]] mesh::VertexId ancestor(mesh::VertexId v) const;

 private:
  std::int32_t num_vertices_;                                       // before the cuts
  std::unordered_map<mesh::VertexId, mesh::VertexId> copied_from_;  // looked up, never iterated
};

}  // namespace kerf::sheet
