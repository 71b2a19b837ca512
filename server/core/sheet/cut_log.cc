#include "server/core/sheet/cut_log.h"

#include <utility>

namespace kerf::sheet {

void CutLog::add(std::vector<DoneCut> cuts, const mesh::TriangleMesh& mesh, const linear::VertexField& x,
                 const std::vector<fem::Material>& materials, std::vector<scene::CutReply>& replies) {
  std::vector<scene::LineageChange> changes;
  bool fell_apart = false;
  for (DoneCut& cut : cuts) {
    cut.number = ++last_number_;
    cut.lineage = lineage_.split(cut.edit.edit.split_from, cut.edit.edit.removed_pieces, cut.number);
    fell_apart = fell_apart || !cut.lineage.born.empty() || !cut.lineage.given_up.empty();
    changes.push_back(cut.lineage);
  }
  std::vector<std::vector<scene::SplitPiece>> splits(cuts.size());
  if (fell_apart)
    splits = scene::describe_splits(changes, scene::measure_pieces(mesh, lineage_.pieces(), x, materials));
  std::size_t next = 0;
  for (scene::CutReply& reply : replies) {
    if (reply.status != cut::CutStatus::kApplied) continue;
    reply.number = cuts[next].number;
    reply.split_pieces = std::move(splits[next]);
    ++next;
  }
  num_cuts_ += static_cast<std::int64_t>(cuts.size());
  history_.add(std::move(cuts));
}

void CutLog::undo(const std::vector<DoneCut>& cuts) {
  for (auto cut = cuts.rbegin(); cut != cuts.rend(); ++cut) lineage_.undo(cut->lineage);
}

void CutLog::redo(const std::vector<DoneCut>& cuts) {
  for (const DoneCut& cut : cuts) lineage_.redo(cut.lineage);
  num_cuts_ += static_cast<std::int64_t>(cuts.size());
}

}  // namespace kerf::sheet
