// Edits of the mesh of a moving sheet, and updates of everything derived from it.

#include <algorithm>
#include <utility>

#include "server/base/sort_unique.h"
#include "server/core/fem/model/transfer.h"
#include "server/core/scene/region.h"
#include "server/core/sheet/lip_parting.h"
#include "server/core/sheet/moving_sheet.h"

namespace kerf::sheet {

std::optional<cut::ShiftLimit> MovingSheet::most_shift_in_cuts(std::vector<std::uint8_t>& is_apart) {
  constexpr double kShareOfThickness = 0.05;  // -, more than lips are parted, less than the gap between most folds
  constexpr double kShareOfEdge = 0.1;        // -, strains the sheet by about its square
  if (!stepper_.contact().touches_itself()) return std::nullopt;
  const double thickness = stepper_.contact().self_thickness();
  const double near = kShareOfThickness * thickness, apart = std::max(near, kShareOfEdge * mesh_.base_edge_length());
  // Both sides of a gap may move.
  stepper_.contact().find_apart(thickness + 2.0 * apart, state_.x, is_apart);
  return cut::ShiftLimit{near, apart, is_apart};
}

bool MovingSheet::follow(std::span<const mesh::MeshEdit* const> edits, const std::vector<mesh::TriangleId>& rewritten,
                         PhaseObserver* observer) {
  for (const mesh::MeshEdit* edit : edits) {
    removed_.insert(removed_.end(), edit->removed_vertices.begin(), edit->removed_vertices.end());
  }
  std::sort(removed_.begin(), removed_.end());
  const fem::MassChange change = model_.follow(mesh_, rewritten, observer);
  enter_phase(observer, "state");
  fem::transfer_state(edits, model_, change, state_);
  std::vector<mesh::VertexId> inherited = pins_.vertices();
  for (const mesh::MeshEdit* edit : edits) scene::inherit_pins(*edit, inherited);
  // Old pins keep their targets, whatever the transfer did. New pins are held where they are.
  for (const fem::Pin& p : pins_.holds()) {
    if (mesh_.has_material(p.vertex)) state_.x.col(p.vertex) = p.target;
  }
  if (stepper_.contact().touches_itself()) {
    sort_unique(inherited);
    part_lips(mesh_, rewritten, inherited, stepper_.contact().self_thickness(), state_.x);
  }
  return finish_edit(std::move(inherited), edits, observer);
}

bool MovingSheet::revert(std::span<const mesh::RevertedEdit> reverted, const VertexAncestry& ancestry,
                         const std::vector<mesh::TriangleId>& rewritten, std::span<const fem::Pin> lost,
                         PhaseObserver* observer) {
  const fem::MassChange change = model_.follow(mesh_, rewritten, observer);
  enter_phase(observer, "state");
  fem::revert_state(reverted, model_, change, state_);
  std::vector<mesh::VertexId> still_pinned;
  for (auto p = pins_.holds().rbegin(); p != pins_.holds().rend(); ++p) {  // backwards: vertices that remain come after
                                                                           // their copies
    const mesh::VertexId vertex = ancestry.ancestor(p->vertex);
    if (vertex == mesh::kNone) continue;
    state_.x.col(vertex) = p->target;
    still_pinned.push_back(vertex);
  }
  std::erase_if(removed_, [&](mesh::VertexId v) { return v >= mesh_.num_vertices() || mesh_.has_material(v); });
  for (const fem::Pin& p : lost) {
    state_.x.col(p.vertex) = p.target;
    still_pinned.push_back(p.vertex);
  }
  sort_unique(still_pinned);
  return finish_edit(std::move(still_pinned), {}, observer);
}

bool MovingSheet::finish_edit(std::vector<mesh::VertexId> now_pinned, std::span<const mesh::MeshEdit* const> edits,
                              PhaseObserver* observer) {
  const bool pins_changed = now_pinned != pins_.vertices();
  pin(std::move(now_pinned));
  stepper_.contact().set_mesh(mesh_);
  conditions_.follow(mesh_, edits, initial_->built);
  grabs_.follow(mesh_);
  enter_phase(observer, "integrator");
  const bool has_slopes = conditions_.has_slopes();
  if (has_slopes) conditions_.hold_slopes(mesh_, model_);
  stepper_.follow(model_, materials_.softening(), state_.x.cols(), has_slopes);
  return pins_changed;
}

}  // namespace kerf::sheet
