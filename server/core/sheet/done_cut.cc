#include "server/core/sheet/done_cut.h"

#include <algorithm>

#include "server/base/sort_unique.h"

namespace kerf::sheet {

namespace {

template <typename T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

std::size_t bytes_of(const mesh::UndoLog& log) {
  return bytes_of(log.points) + bytes_of(log.vertices) + bytes_of(log.triangles);
}

}  // namespace

std::size_t bytes_of(const DoneCut& cut) {
  const mesh::MeshEdit& edit = cut.edit.edit;
  return sizeof(cut) + bytes_of(edit.added_vertices) + bytes_of(edit.moved_vertices) +
         bytes_of(edit.rewritten_triangles) + bytes_of(edit.split_from) + bytes_of(cut.edit.undo) +
         bytes_of(cut.again) + bytes_of(edit.removed_vertices) + bytes_of(edit.removed_pieces) +
         bytes_of(cut.lineage.ended) + bytes_of(cut.lineage.born) + bytes_of(cut.lineage.given_up) +
         bytes_of(cut.lost_pins);
}

std::vector<const mesh::MeshEdit*> edits_of(const std::vector<DoneCut>& cuts) {
  std::vector<const mesh::MeshEdit*> edits;
  edits.reserve(cuts.size());
  for (const DoneCut& cut : cuts) edits.push_back(&cut.edit.edit);
  return edits;
}

std::vector<mesh::TriangleId> rewritten_slots(const std::vector<DoneCut>& cuts, std::int32_t num_slots) {
  if (cuts.size() == 1 && cuts[0].edit.undo.num_triangle_slots_after <= num_slots) {
    return cuts[0].edit.edit.rewritten_triangles;
  }
  std::vector<mesh::TriangleId> slots;
  for (const DoneCut& cut : cuts) {
    const auto& rewritten = cut.edit.edit.rewritten_triangles;
    slots.insert(slots.end(), rewritten.begin(), std::lower_bound(rewritten.begin(), rewritten.end(), num_slots));
  }
  sort_unique(slots);
  return slots;
}

}  // namespace kerf::sheet
