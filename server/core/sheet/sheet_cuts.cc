// Cuts, batches of cuts, undo and redo: what changes the mesh, and what follows from it.

#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>

#include "server/base/sort_unique.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/model/transfer.h"
#include "server/core/mesh/mesh_revert.h"
#include "server/core/scene/material_point.h"
#include "server/core/scene/region.h"
#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

namespace {

std::vector<const mesh::MeshEdit*> edits_of(const std::vector<DoneCut>& cuts) {
  std::vector<const mesh::MeshEdit*> edits;
  edits.reserve(cuts.size());
  for (const DoneCut& cut : cuts) edits.push_back(&cut.edit.edit);
  return edits;
}

// Slots below `num_slots` that the cuts rewrote; sorted, unique.
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

// The vertices that those which the cuts made were copied from, and that are there without them.
class Origins {
 public:
  explicit Origins(const std::vector<DoneCut>& cuts) : num_vertices_(cuts.front().edit.undo.num_vertices) {
    for (const DoneCut& cut : cuts) {
      for (const mesh::VertexSource& added : cut.edit.edit.added_vertices) {
        if (mesh::is_copy(added)) origins_.emplace(added.vertex, added.sources[0]);
      }
    }
  }
  [[nodiscard]] bool goes(mesh::VertexId v) const { return v >= num_vertices_; }
  // kNone for a vertex at a point that the cuts made.
  [[nodiscard]] mesh::VertexId of(mesh::VertexId v) const {
    while (goes(v)) {
      const auto origin = origins_.find(v);
      if (origin == origins_.end()) return mesh::kNone;
      v = origin->second;
    }
    return v;
  }

 private:
  std::int32_t num_vertices_;
  std::unordered_map<mesh::VertexId, mesh::VertexId> origins_;  // looked up, never iterated
};

}  // namespace

Result<CommandReply> Sheet::Impl::cut(const Cut& cut, const CommandContext& context) {
  KERF_TRY_ASSIGN(std::vector<CutReply> replies, do_cuts({&cut, 1}, false, context));
  CommandReply reply = plain_reply();
  reply.cut = std::move(replies.front());
  return reply;
}

Result<CommandReply> Sheet::Impl::cut_batch(const CutBatch& batch, const CommandContext& context) {
  KERF_TRY_ASSIGN(std::vector<CutReply> replies, do_cuts(batch.cuts, true, context));
  CommandReply reply = plain_reply();
  reply.batch = std::move(replies);
  return reply;
}

Result<std::vector<CutReply>> Sheet::Impl::do_cuts(std::span<const Cut> cuts, bool is_batch,
                                                   const CommandContext& context) {
  std::vector<DoneCut> done;
  const auto carry_out = [&] {
    const StageScope scope(context.observer, Stage::kCut, context.index);
    return cut_mesh(cuts, is_batch, done, context.observer);
  };
  Result<std::vector<CutReply>> replies = carry_out();
  if (!replies.ok() || done.empty()) return replies;

  const StageScope scope(context.observer, Stage::kModelUpdate, context.index);
  follow(done, context.observer);
  enter_phase(context.observer, "pieces and history");
  std::vector<LineageChange> changes;
  bool fell_apart = false;
  for (DoneCut& cut : done) {
    cut.number = ++last_cut_number;
    cut.lineage = lineage.split(cut.edit.edit.split_from, cut.edit.edit.vanished_pieces, cut.number);
    fell_apart = fell_apart || !cut.lineage.born.empty() || !cut.lineage.given_up.empty();
    changes.push_back(cut.lineage);
  }
  std::vector<std::vector<SplitPiece>> splits(done.size());
  if (fell_apart) {
    splits = describe_splits(changes, measure_pieces(mesh, lineage.pieces(), state.x, materials->by_region));
  }
  std::size_t next = 0;
  for (CutReply& reply : *replies) {
    if (reply.status != cut::CutStatus::kApplied) continue;
    reply.number = done[next].number;
    reply.split_pieces = std::move(splits[next]);
    ++next;
  }
  num_cuts += static_cast<std::int64_t>(done.size());
  history.add(std::move(done));
  return replies;
}

Result<std::vector<CutReply>> Sheet::Impl::cut_mesh(std::span<const Cut> cuts, bool is_batch,
                                                    std::vector<DoneCut>& done, PhaseObserver* observer) {
  std::vector<CutReply> replies;
  std::vector<mesh::VertexId> pins = pinned;  // as they will be when it is the cut's turn
  // The same of positions, which only cuts on a picture look at.
  mesh::VertexField positions;
  const bool has_view = std::any_of(cuts.begin(), cuts.end(), [](const Cut& cut) { return cut.view.has_value(); });
  if (is_batch && has_view) positions = state.x;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    enter_phase(observer, "plan");
    cut::CutRequest request = request_of(cuts[i]);
    request.positions = is_batch ? &positions : &state.x;
    request.fixed_vertices = pins;
    for (const GrabState& held : grabs) {
      auto& fixed = request.fixed_vertices;  // stays sorted: plan() need not
      const mesh::VertexId vertex = held.vertices[0];
      if (!held.material) fixed.insert(std::upper_bound(fixed.begin(), fixed.end(), vertex), vertex);
    }
    const double mass_before = cuts[i].options.width_m && !has_one_material() ? rest_mass() : 0.0;
    const Result<cut::CutPlan> plan = cut::plan(mesh, request);
    Result<cut::CutOutcome> outcome =
        plan.ok() ? cut::apply(mesh, *plan, observer) : Result<cut::CutOutcome>(plan.error());
    if (!outcome.ok()) {
      for (auto cut = done.rbegin(); cut != done.rend(); ++cut) cut->edit.undo.undo(mesh);
      done.clear();
      return is_batch ? in_batch(outcome.error(), i) : outcome.error();
    }
    enter_phase(observer, "keep for undo");
    replies.push_back(reply_of(*outcome, cuts[i], mass_before));
    if (outcome->status != cut::CutStatus::kApplied) continue;
    if (is_batch) inherit_pins(outcome->edit, pins);
    if (is_batch && has_view) fem::carry_over(outcome->edit, positions);
    mesh::UndoLog again = outcome->undo.inverse(mesh);
    std::vector<fem::Pin> lost = pins_lost_by(outcome->edit);
    done.push_back(
        {{std::move(outcome->edit), std::move(outcome->undo)}, std::move(again), 0, {}, std::move(lost), pins_version});
  }
  return replies;
}

// Brings everything that is derived from the mesh up to date with cuts of it.
void Sheet::Impl::follow(const std::vector<DoneCut>& cuts, PhaseObserver* observer) {
  const std::vector<const mesh::MeshEdit*> edits = edits_of(cuts);
  for (const mesh::MeshEdit* edit : edits) {
    removed.insert(removed.end(), edit->removed_vertices.begin(), edit->removed_vertices.end());
  }
  std::sort(removed.begin(), removed.end());
  const fem::MassChange change = model.follow(mesh, rewritten_slots(cuts, mesh.num_triangle_slots()), observer);
  enter_phase(observer, "state");
  fem::transfer_state(edits, model, change, state);
  std::vector<mesh::VertexId> inherited = pinned;
  for (const mesh::MeshEdit* edit : edits) inherit_pins(*edit, inherited);
  // Old pins keep their targets: nothing may have moved them. The new ones are held where they are.
  for (const fem::Pin& p : holds) {
    if (mesh.has_material(p.vertex)) state.x.col(p.vertex) = p.target;
  }
  finish_edit(std::move(inherited), edits, observer);
  topology.note(edits);
}

Result<CommandReply> Sheet::Impl::undo_cut(const CommandContext& context) {
  KERF_TRY_ASSIGN(const std::shared_ptr<const UndoStep> step, history.take_done());
  if (step->before_reset) {
    restore(*step->before_reset);
  } else {
    take_back(step->cuts, context);
  }
  return undo_reply(*step);
}

Result<CommandReply> Sheet::Impl::redo_cut(const CommandContext& context) {
  KERF_TRY_ASSIGN(const std::shared_ptr<const UndoStep> step, history.take_undone());
  if (step->before_reset) {
    redo_reset(*step);
    return undo_reply(*step);
  }
  const std::vector<DoneCut>& cuts = step->cuts;
  {
    const StageScope scope(context.observer, Stage::kCut, context.index);
    for (const DoneCut& cut : cuts) {
      cut.again.undo(mesh);
      lineage.redo(cut.lineage);
    }
  }
  const StageScope scope(context.observer, Stage::kModelUpdate, context.index);
  follow(cuts, context.observer);
  num_cuts += static_cast<std::int64_t>(cuts.size());
  return undo_reply(*step);
}

void Sheet::Impl::take_back(const std::vector<DoneCut>& cuts, const CommandContext& context) {
  const Origins origins(cuts);
  for (GrabState& held : grabs) {
    const mesh::VertexId vertex = held.vertices[0];
    if (held.material || !origins.goes(vertex)) continue;
    const mesh::VertexId origin = origins.of(vertex);
    if (origin != mesh::kNone) {
      held.vertices[0] = origin;
    } else {
      held.material = mesh.rest_position(vertex);
    }
  }
  std::vector<mesh::RevertedEdit> reverted;
  reverted.reserve(cuts.size());
  {
    const StageScope scope(context.observer, Stage::kCut, context.index);
    for (auto cut = cuts.rbegin(); cut != cuts.rend(); ++cut) {
      reverted.push_back(mesh::revert(mesh, cut->edit));
      lineage.undo(cut->lineage);
    }
  }
  const StageScope scope(context.observer, Stage::kModelUpdate, context.index);
  const fem::MassChange change = model.follow(mesh, rewritten_slots(cuts, mesh.num_triangle_slots()), context.observer);
  enter_phase(context.observer, "state");
  fem::revert_state(reverted, model, change, state);
  // A vertex that a pinned one joins is held where that was; one that was pinned itself, where it was.
  std::vector<mesh::VertexId> still_pinned;
  for (auto p = holds.rbegin(); p != holds.rend(); ++p) {  // the ids that remain last
    const mesh::VertexId vertex = origins.of(p->vertex);
    if (vertex == mesh::kNone) continue;
    state.x.col(vertex) = p->target;
    still_pinned.push_back(vertex);
  }
  std::erase_if(removed, [&](mesh::VertexId v) { return v >= mesh.num_vertices() || mesh.has_material(v); });
  for (const DoneCut& cut : cuts) {
    if (cut.pins_version != pins_version) continue;
    for (const fem::Pin& p : cut.lost_pins) {
      state.x.col(p.vertex) = p.target;
      still_pinned.push_back(p.vertex);
    }
  }
  sort_unique(still_pinned);
  finish_edit(std::move(still_pinned), {}, context.observer);
  topology.replace();
}

std::vector<fem::Pin> Sheet::Impl::pins_lost_by(const mesh::MeshEdit& edit) const {
  std::vector<fem::Pin> lost;
  for (const fem::Pin& p : holds) {
    if (std::binary_search(edit.removed_vertices.begin(), edit.removed_vertices.end(), p.vertex)) lost.push_back(p);
  }
  return lost;
}

// Updates everything else once mesh, model and state have the same topology again.
void Sheet::Impl::finish_edit(std::vector<mesh::VertexId> now_pinned, std::span<const mesh::MeshEdit* const> edits,
                              PhaseObserver* observer) {
  if (now_pinned != pinned) ++settings_version;
  pin(std::move(now_pinned));
  follow_conditions(edits);
  for (GrabState& held : grabs) {
    if (!held.material && !mesh.has_material(held.vertices[0])) held.material = mesh.rest_position(held.vertices[0]);
    if (!held.material) continue;
    const std::optional<MaterialPoint> found = find_material_point(mesh, *held.material);
    const MaterialPoint point = found ? *found : nearest_material_point(mesh, *held.material);
    held.vertices = point.vertices;
    held.weights = point.weights;
  }
  enter_phase(observer, "integrator");
  if (held_vertices.has_slopes()) set_slopes(now);
  if (held_vertices.has_slopes() || frozen) {  // a step may have left it half-done
    integrator->rebuild(model);
  } else {
    integrator->follow(model);
  }
  make_room();
  ++topology_version;
}

CommandReply Sheet::Impl::undo_reply(const UndoStep& step) const {
  UndoReply undone;
  for (const DoneCut& cut : step.cuts) undone.cuts.push_back(cut.number);
  undone.reset = step.before_reset != nullptr;
  undone.pieces = mesh.num_pieces();
  undone.undo_steps = static_cast<std::int32_t>(history.num_done());
  undone.redo_steps = static_cast<std::int32_t>(history.num_undone());
  CommandReply reply = plain_reply();
  reply.undone = std::move(undone);
  return reply;
}

}  // namespace kerf::sheet
