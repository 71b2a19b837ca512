#include "server/core/sheet/vertex_ancestry.h"

#include "server/core/mesh/mesh_revert.h"

namespace kerf::sheet {

VertexAncestry::VertexAncestry(const std::vector<DoneCut>& cuts) : num_vertices_(cuts.front().edit.undo.num_vertices) {
  for (const DoneCut& cut : cuts) {
    for (const mesh::VertexSource& added : cut.edit.edit.added_vertices) {
      if (mesh::is_copy(added)) copied_from_.emplace(added.vertex, added.sources[0]);
    }
  }
}

mesh::VertexId VertexAncestry::ancestor(mesh::VertexId v) const {
  while (is_new(v)) {
    const auto source = copied_from_.find(v);
    if (source == copied_from_.end()) return mesh::kNone;
    v = source->second;
  }
  return v;
}

}  // namespace kerf::sheet
