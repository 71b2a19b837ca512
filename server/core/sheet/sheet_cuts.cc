// Cuts, batches of cuts, undo and redo: changes of the mesh, and updates of everything that depends on it.

#include <algorithm>
#include <utility>

#include "server/core/mesh/mesh_revert.h"
#include "server/core/scene/integrator_settings.h"
#include "server/core/sheet/mesh_cuts.h"
#include "server/core/sheet/sheet_impl.h"
#include "server/core/sheet/vertex_ancestry.h"

namespace kerf::sheet {

Result<scene::CommandReply> Sheet::Impl::cut(const scene::Cut& cut, const CommandContext& context) {
  KERF_TRY_ASSIGN(std::vector<scene::CutReply> replies, do_cuts({&cut, 1}, false, context));
  scene::CommandReply reply = plain_reply();
  reply.cut = std::move(replies.front());
  return reply;
}

Result<scene::CommandReply> Sheet::Impl::cut_batch(const scene::CutBatch& batch, const CommandContext& context) {
  KERF_TRY_ASSIGN(std::vector<scene::CutReply> replies, do_cuts(batch.cuts, true, context));
  scene::CommandReply reply = plain_reply();
  reply.batch = std::move(replies);
  return reply;
}

Result<std::vector<scene::CutReply>> Sheet::Impl::do_cuts(std::span<const scene::Cut> wanted, bool is_batch,
                                                          const CommandContext& context) {
  const scene::SheetConfig& config = moving.config();
  std::vector<std::uint8_t> is_apart;
  const CutSurroundings around{.max_vertices = std::min(config.max_vertices, scene::vertex_limit(config.integrator)),
                               .pins = moving.pins(),
                               .grabs = moving.grabs(),
                               .positions = moving.state().x,
                               .materials = moving.materials().by_region(),
                               .most_shift = moving.most_shift_in_cuts(is_apart),
                               .components = moving.initial().built.components};
  const auto cut_the_mesh = [&] {
    const StageScope scope(Stage::kCut, context);
    return cut_mesh(wanted, is_batch, around, moving.mesh_to_edit(), context.observer);
  };
  KERF_TRY_ASSIGN(MeshCuts made, cut_the_mesh());
  if (made.done.empty()) return std::move(made.replies);
  const StageScope scope(Stage::kModelUpdate, context);
  follow(made.done, context.observer);
  enter_phase(context.observer, "pieces and history");
  cuts.add(std::move(made.done), moving.mesh(), moving.state().x, moving.materials().by_region(), made.replies);
  return std::move(made.replies);
}

Result<scene::CommandReply> Sheet::Impl::undo_cut(const CommandContext& context) {
  KERF_TRY_ASSIGN(const std::shared_ptr<const UndoStep> step, cuts.history().take_done());
  if (step->before_reset) {
    restore(*step->before_reset);
  } else {
    revert(step->cuts, context);
  }
  return undo_reply(*step);
}

Result<scene::CommandReply> Sheet::Impl::redo_cut(const CommandContext& context) {
  KERF_TRY_ASSIGN(const std::shared_ptr<const UndoStep> step, cuts.history().take_undone());
  if (step->before_reset) {
    redo_reset(*step);
  } else {
    redo(step->cuts, context);
  }
  return undo_reply(*step);
}

void Sheet::Impl::follow(const std::vector<DoneCut>& done, PhaseObserver* observer) {
  const std::vector<const mesh::MeshEdit*> edits = edits_of(done);
  if (moving.follow(edits, rewritten_slots(done, moving.mesh().num_triangle_slots()), observer)) ++settings_version;
  ++topology_version;
  topology.add_edits(edits);
}

void Sheet::Impl::redo(const std::vector<DoneCut>& done, const CommandContext& context) {
  {
    const StageScope scope(Stage::kCut, context);
    for (const DoneCut& cut : done) cut.again.undo(moving.mesh_to_edit());
    cuts.redo(done);
  }
  const StageScope scope(Stage::kModelUpdate, context);
  follow(done, context.observer);
}

void Sheet::Impl::revert(const std::vector<DoneCut>& done, const CommandContext& context) {
  const VertexAncestry ancestry(done);
  moving.leave_new_vertices(ancestry);
  std::vector<mesh::RevertedEdit> reverted;
  reverted.reserve(done.size());
  {
    const StageScope scope(Stage::kCut, context);
    for (auto cut = done.rbegin(); cut != done.rend(); ++cut) {
      reverted.push_back(mesh::revert(moving.mesh_to_edit(), cut->edit));
    }
    cuts.undo(done);
  }
  const StageScope scope(Stage::kModelUpdate, context);
  std::vector<fem::Pin> lost_pins;
  for (const DoneCut& cut : done) {
    if (cut.pins_version != moving.pins().version()) continue;
    lost_pins.insert(lost_pins.end(), cut.lost_pins.begin(), cut.lost_pins.end());
  }
  const std::vector<mesh::TriangleId> rewritten = rewritten_slots(done, moving.mesh().num_triangle_slots());
  if (moving.revert(reverted, ancestry, rewritten, lost_pins, context.observer)) ++settings_version;
  ++topology_version;
  topology.replace();
}

scene::CommandReply Sheet::Impl::undo_reply(const UndoStep& step) const {
  scene::UndoReply undone;
  for (const DoneCut& cut : step.cuts) undone.cuts.push_back(cut.number);
  undone.reset = step.before_reset != nullptr;
  undone.pieces = moving.mesh().num_pieces();
  undone.undo_steps = static_cast<std::int32_t>(cuts.history().num_done());
  undone.redo_steps = static_cast<std::int32_t>(cuts.history().num_undone());
  scene::CommandReply reply = plain_reply();
  reply.undone = std::move(undone);
  return reply;
}

}  // namespace kerf::sheet
