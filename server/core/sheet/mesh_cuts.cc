#include "server/core/sheet/mesh_cuts.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <utility>

#include "server/core/cut/cut.h"
#include "server/core/fem/model/transfer.h"
#include "server/core/scene/components.h"
#include "server/core/scene/region.h"
#include "server/core/sheet/material_setup.h"

namespace kerf::sheet {

namespace {

std::string millimetres(double metres) {
  std::array<char, 32> text{};
  const double mm = 1e3 * metres;
  std::snprintf(text.data(), text.size(), mm < 100.0 ? "%.2g mm" : "%.0f mm", mm);
  return text.data();
}

// Returns the warnings of a reply; `remarks` come first. Closed gaps and merged segments cause none, as they are below
// the cut's tolerance.
std::vector<std::string> warnings_of(const cut::CutReport& report, const std::vector<std::string>& remarks) {
  std::vector<std::string> warnings = remarks;
  if (report.triangles_behind > 0) {
    warnings.push_back("triangles that reach behind the camera, left out: " + std::to_string(report.triangles_behind));
  }
  if (report.view_deviation_m > 0.0) {
    warnings.push_back("seen nearly edge-on: the cut is up to " + millimetres(report.view_deviation_m) +
                       " off the sight lines");
  }
  if (const cut::JoinReport& joins = report.joins; joins.near_ends > 0) {
    warnings.push_back(std::to_string(joins.near_ends) +
                       (joins.near_ends == 1 ? " end nearly meets" : " ends nearly meet") +
                       " another line, a cut or the border and " + (joins.near_ends == 1 ? "stays" : "stay") +
                       " open, " + (joins.near_ends == 1 ? "" : "the closest ") + millimetres(joins.nearest_end_m) +
                       " away; join_m (--join) joins ends that are closer than it");
  }
  if (report.refinement_stopped) warnings.emplace_back("refinement stopped early: some new triangles are flat");
  return warnings;
}

// Makes the reply to a cut. `mass_before`: mass of the sheet before the cut, kg; used only if it has several materials.
scene::CutReply reply_of(const cut::CutOutcome& outcome, const scene::Cut& cut, const mesh::TriangleMesh& mesh,
                         const std::vector<fem::Material>& materials, double mass_before) {
  scene::CutReply reply;
  reply.status = outcome.status;
  reply.report = outcome.report;
  reply.report.pieces = mesh.num_pieces();
  reply.warnings = warnings_of(outcome.report, cut.remarks);
  if (cut.options.width_m && outcome.status == cut::CutStatus::kApplied) {
    const double density = materials[0].density * materials[0].thickness;
    reply.removed_mass =
        materials.size() == 1 ? density * outcome.report.removed_area_m2 : mass_before - rest_mass(mesh, materials);
  }
  return reply;
}

// Cuts the mesh along a cut's curve; `request` has all but what the cut itself says.
Result<cut::CutOutcome> plan_and_apply(const scene::Cut& cut, std::span<const scene::ComponentPlace> components,
                                       cut::CutRequest request, mesh::TriangleMesh& mesh, PhaseObserver* observer) {
  KERF_TRY(scene::place(cut, components, request));
  KERF_TRY_ASSIGN(const cut::CutPlan plan, cut::plan(mesh, request));
  return cut::apply(mesh, plan, observer);
}

}  // namespace

Result<MeshCuts> cut_mesh(std::span<const scene::Cut> cuts, bool is_batch, const CutSurroundings& around,
                          mesh::TriangleMesh& mesh, PhaseObserver* observer) {
  MeshCuts made;
  // Pins and positions before each cut of a batch. Positions are needed for cuts on a picture and of bent sheets.
  std::vector<mesh::VertexId> pins = around.pins.vertices();
  linear::VertexField positions;
  const bool needs_positions =
      around.most_shift.has_value() ||
      std::any_of(cuts.begin(), cuts.end(), [](const scene::Cut& cut) { return cut.view.has_value(); });
  if (is_batch && needs_positions) positions = around.positions;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const scene::Cut& cut = cuts[i];
    enter_phase(observer, "plan");
    cut::CutRequest request;
    request.max_vertices = around.max_vertices;
    request.positions = is_batch ? &positions : &around.positions;
    request.most_shift = around.most_shift;
    request.fixed_vertices = pins;
    around.grabs.add_vertices_to(request.fixed_vertices);
    const double mass_before =
        cut.options.width_m && around.materials.size() > 1 ? rest_mass(mesh, around.materials) : 0.0;
    Result<cut::CutOutcome> outcome = plan_and_apply(cut, around.components, std::move(request), mesh, observer);
    if (!outcome.ok()) {
      for (auto done = made.done.rbegin(); done != made.done.rend(); ++done) done->edit.undo.undo(mesh);
      return is_batch ? scene::in_batch(outcome.error(), i) : outcome.error();
    }
    enter_phase(observer, "keep for undo");
    made.replies.push_back(reply_of(*outcome, cut, mesh, around.materials, mass_before));
    if (outcome->status != cut::CutStatus::kApplied) continue;
    if (is_batch) scene::inherit_pins(outcome->edit, pins);
    if (is_batch && needs_positions) fem::carry_over(outcome->edit, positions);
    mesh::UndoLog again = outcome->undo.inverse(mesh);
    std::vector<fem::Pin> lost = around.pins.lost_by(outcome->edit);
    made.done.push_back({{std::move(outcome->edit), std::move(outcome->undo)},
                         std::move(again),
                         0,
                         {},
                         std::move(lost),
                         around.pins.version()});
  }
  return made;
}

}  // namespace kerf::sheet
