#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "server/base/check.h"
#include "server/base/elementary.h"
#include "server/core/cut/bisection.h"
#include "server/core/cut/crossed_triangles.h"
#include "server/core/cut/cut.h"
#include "server/core/cut/cut_quality.h"
#include "server/core/cut/path_insertion.h"
#include "server/core/cut/path_scale.h"
#include "server/core/cut/strip.h"
#include "server/core/mesh/id_map.h"
#include "server/core/mesh/refine/refinement.h"
#include "server/core/mesh/refine/relaxation.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::LatticePoint;
using mesh::PointId;
using mesh::TriangleId;
using mesh::TriangleMesh;

namespace {

constexpr double kSpacing = 0.8;  // -; longest stretch of path without a point, over the edge length
constexpr double kNoSpacing =
    std::numeric_limits<double>::infinity();  // the edges of the crossed elements already divide the path

// Relaxation leaves an old vertex in place if the worst triangle around it has at least this
// mesh::TriangleShape::quality. A right triangle with equal legs has 0.87, one with a leg half as long 0.69.
// kWellShapedFine is for cuts with a larger min_angle_deg than the default.
constexpr double kWellShaped = 0.6;
constexpr double kWellShapedFine = 0.8;

// Most insertions in refinement: some for each path point, and a fixed number for tips, corners and loops of small
// cuts. They are about ten times what cuts have needed. If they are used up, the cut is still made, with lower quality.
constexpr std::int64_t kInsertionsPerPathPoint = 60;
constexpr std::int64_t kInsertionsBeside = 2'000;

// Smallest angle that refinement makes in a cut that keeps edges, over CutOptions::min_angle_deg. Paths meet these
// edges at any angle, so the whole angle would cost twice as many vertices. -
constexpr double kAngleBesideKeptEdges = 0.5;

constexpr double kLengthFloor = 0.25;  // -; RefinementConfig::length_floor over the snap distance
// Most insertions around a tip, for gradient 1 and edges that have the wanted length already.
constexpr double kInsertionsPerTip = 400.0;
// The search for triangles to grade ends where the grading allows edges of this many local edge lengths. -
constexpr double kGradedReach = 3.0;

constexpr int kCloserAttempts = 2;    // most further attempts, see needs_less_snapping()
constexpr double kCloserSnap = 0.01;  // -; factor on the snap distance in each further attempt

class Cutter {
 public:
  Cutter(TriangleMesh& mesh, const CutPlan& plan, PhaseObserver* observer)
      : mesh_(mesh),
        plan_(plan),
        observer_(observer),
        spacing_(mesh.lattice().spacing),
        scale_(mesh, plan.options, plan.snap),
        editor_(mesh, slot_limit(mesh, plan)),
        insertion_(editor_, scale_, is_by_element() ? kNoSpacing : kSpacing,
                   plan.options.width_m ? &outline_edges_ : nullptr) {}

  Result<CutOutcome> run() {
    CutOutcome outcome;
    outcome.report.triangles_behind = plan_.triangles_behind;
    outcome.report.joins = plan_.joins;
    enter_phase(observer_, "insert path");
    const std::vector<TriangleId> crossed = crossed_triangles(mesh_, plan_.strokes);
    outcome.report.crossed_triangles = static_cast<std::int32_t>(crossed.size());
    if (is_by_element()) lock_elements(editor_, crossed);
    keep_edges();
    for (const Stroke& stroke : plan_.strokes) {
      KERF_TRY(insertion_.insert(stroke));
    }
    KERF_TRY(insertion_.split_lone_edges());
    if (has_width()) {
      KERF_TRY_ASSIGN(strip_, strip_triangles(mesh_, outline_edges_, plan_.outline, plan_.room, max_strip_area()));
    }
    if (has_width() ? strip_.empty() : insertion_.counts().new_lip_edges == 0) {
      editor_.rollback();
      outcome.report.pieces = mesh_.num_pieces();
      report_snapping(outcome.report);
      return outcome;
    }
    if (deviation_of_tolerance() > 1.0 || deviation_of_width() > 1.0) return tolerance_not_kept();
    if (has_width()) remove_strip(outcome.report);
    path_ = insertion_.path_points();
    corridor_ = insertion_.corridor_points();
    KERF_TRY_ASSIGN(const mesh::RefinementCounts refined, is_by_element() ? bisect() : relax_and_refine());
    outcome.report.refinement_stopped = refined.stopped;
    enter_phase(observer_, "open lips");
    editor_.open();
    if (mesh_.num_vertices() > plan_.max_vertices) return too_many_vertices();
    enter_phase(observer_, "commit");
    mesh::CommittedEdit committed = editor_.commit();
    outcome.status = CutStatus::kApplied;
    outcome.edit = std::move(committed.edit);
    outcome.undo = std::move(committed.undo);
    enter_phase(observer_, "measure");
    fill_report(outcome);
    return outcome;
  }

 private:
  static std::int32_t slot_limit(const TriangleMesh& mesh, const CutPlan& plan) {
    const std::int64_t wanted = std::int64_t{mesh.num_triangle_slots()} + plan.options.max_new_triangles;
    return static_cast<std::int32_t>(std::min<std::int64_t>(wanted, mesh::MeshEditor::kDefaultMaxSlots));
  }

  void keep_edges() {
    for (const auto& [p, q] : plan_.kept_edges) {
      int corner = 0;
      const TriangleId t = mesh_.find_edge(p, q, corner);
      if (t != kNone) editor_.lock_edge(t, corner, mesh::kLockOriginal);
    }
  }

  [[nodiscard]] bool has_width() const { return plan_.options.width_m.has_value(); }

  // Returns an upper bound on the area (m^2) of the strip, with its outline as far out as the tolerance allows.
  [[nodiscard]] double max_strip_area() const {
    double length = 0.0;
    for (const Stroke& stroke : plan_.outline) {
      for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
        length += (stroke.points[i + 1] - stroke.points[i]).norm();
      }
    }
    return plan_.strip_area_m2 + 2.0 * length * kToleranceOfWidth * *plan_.options.width_m;
  }

  // Removes the strip. This comes before refinement, as the strip may be far narrower than the triangles beside it.
  void remove_strip(CutReport& report) {
    report.removed_triangles = static_cast<std::int32_t>(strip_.size());
    for (const TriangleId t : strip_) report.removed_area_m2 += mesh_.area(t);
    editor_.remove_triangles(strip_);
  }

  // Returns the deviation by snapping over what the width of a strip allows to each side; 0 without a width.
  [[nodiscard]] double deviation_of_width() const {
    return has_width() ? insertion_.counts().deviation * spacing_ / (0.5 * kToleranceOfWidth * *plan_.options.width_m)
                       : 0.0;
  }

  [[nodiscard]] double deviation_of_tolerance() const {
    return plan_.curve_deviation_of_tolerance + insertion_.counts().deviation_of_tolerance +
           kRoundingUnits * spacing_ / scale_.least_tolerance();
  }

  [[nodiscard]] Error tolerance_not_kept() const {
    return failed_precondition("TOLERANCE_NOT_KEPT",
                               "older lips near the path would divert it by " +
                                   std::to_string(std::max(deviation_of_tolerance(), deviation_of_width())) +
                                   " times the tolerance; shift the curve slightly, or allow a larger tolerance",
                               "cut.curve");
  }

  [[nodiscard]] Error too_many_vertices() const {
    return resource_exhausted("TOO_MANY_VERTICES",
                              "the cut would leave the sheet with " + std::to_string(mesh_.num_vertices()) +
                                  " vertices; its limit is " + std::to_string(plan_.max_vertices) +
                                  "; shorten the cut, or start from a coarser mesh",
                              "cut");
  }

  [[nodiscard]] bool on_path(PointId p) const { return std::binary_search(path_.begin(), path_.end(), p); }
  [[nodiscard]] bool in_corridor(PointId p) const {
    return on_path(p) || std::binary_search(corridor_.begin(), corridor_.end(), p);
  }

  // Adds the solid triangles that the insertion of the path has changed: those with a corner on the path, and those in
  // corridors where edges were flipped.
  void add_touched(mesh::IdMap& touched) const {
    std::vector<TriangleId> fan;
    for (const PointId p : path_) {
      mesh_.fan_around(p, fan);
      for (const TriangleId t : fan) {
        if (mesh_.is_solid(t)) touched.add(t);
      }
    }
    for (const PointId p : corridor_) {
      mesh_.fan_around(p, fan);
      for (const TriangleId t : fan) {
        const auto& points = mesh_.points(t);
        if (mesh_.is_solid(t) && in_corridor(points[0]) && in_corridor(points[1]) && in_corridor(points[2])) {
          touched.add(t);
        }
      }
    }
  }

  void relax_ring() {
    mesh::IdMap touched;
    add_touched(touched);
    mesh::IdMap candidates;
    for (const TriangleId t : touched.ids()) {
      for (const PointId p : mesh_.points(t)) {
        if (!editor_.is_new(p) && !on_path(p)) candidates.add(p);
      }
    }
    const bool is_fine = plan_.options.min_angle_deg > CutOptions{}.min_angle_deg;
    moved_ = relax(editor_, candidates.ids(), plan_.fixed_vertices, is_fine ? kWellShapedFine : kWellShaped);
  }

  [[nodiscard]] bool is_by_element() const { return plan_.options.method == Method::kElement; }

  [[nodiscard]] std::int64_t max_insertions() const {
    return kInsertionsBeside + kInsertionsPerPathPoint * static_cast<std::int64_t>(path_.size());
  }

  Result<mesh::RefinementCounts> bisect() {
    enter_phase(observer_, "refine");
    mesh::IdMap seeds;
    add_touched(seeds);
    return bisect_ill_shaped(editor_, seeds.ids(), scale_,
                             {kLengthFloor * plan_.snap_m / spacing_, max_insertions(), plan_.options.element_limits});
  }

  Result<mesh::RefinementCounts> relax_and_refine() {
    enter_phase(observer_, "relax");
    if (plan_.options.relax) relax_ring();
    enter_phase(observer_, "refine");
    if (plan_.options.min_angle_deg == 0.0 && !plan_.options.tip_edge_length_m) return mesh::RefinementCounts{};
    mesh::IdMap seeds;
    add_touched(seeds);
    std::vector<TriangleId> fan;
    for (const PointId p : moved_) {
      mesh_.fan_around(p, fan);
      for (const TriangleId t : fan) seeds.add(t);
    }
    mesh::RefinementConfig config;
    if (plan_.options.tip_edge_length_m) config.grading = grading();
    add_graded(config.grading, seeds);
    config.min_angle_deg = (plan_.kept_edges.empty() ? 1.0 : kAngleBesideKeptEdges) * plan_.options.min_angle_deg;
    config.length_floor = kLengthFloor * plan_.snap_m / spacing_;
    config.lengths = &mesh_.edge_lengths();
    config.strands = strand_widths(mesh_, plan_.options);
    config.strand_angle_deg = kStrandAngle * plan_.options.min_angle_deg;
    config.max_insertions = max_insertions() + insertions_around(config.grading);
    const mesh::RefinementCounts counts = refine(editor_, seeds.ids(), config);
    if (editor_.budget_exhausted()) {
      return resource_exhausted(
          "CUT_ELEMENT_BUDGET",
          "refining the cut needs more new triangles than allowed; shorten it, or raise max_new_triangles",
          "cut.max_new_triangles");
    }
    return counts;
  }

  [[nodiscard]] mesh::TipGrading grading() const {
    mesh::TipGrading grading;
    for (const PointId p : insertion_.tips()) grading.tips.push_back(mesh_.at(p));
    grading.length = *plan_.options.tip_edge_length_m / spacing_;
    grading.gradient = plan_.options.tip_grading - 1.0;
    return grading;
  }

  // Returns most insertions for the grading: about ten times the triangles that fill the area around the tips at the
  // graded lengths.
  [[nodiscard]] std::int64_t insertions_around(const mesh::TipGrading& grading) const {
    const double growth = logarithm(std::max(plan_.edge_length_m / spacing_ / grading.length, 1.0));
    const double per_tip = kInsertionsPerTip * (1.0 + growth) / (grading.gradient * grading.gradient);
    return grading.tips.empty() ? 0 : std::llround(static_cast<double>(grading.tips.size()) * per_tip);
  }

  // Adds the solid triangles around tips, out to where the grading allows edges of kGradedReach local edge lengths.
  void add_graded(const mesh::TipGrading& grading, mesh::IdMap& seeds) const {
    std::vector<TriangleId> found;
    mesh::IdMap seen;
    for (const LatticePoint& tip : grading.tips) {
      // Takes a triangle that depends only on the point, not on how the search found it.
      const mesh::Location location = mesh_.locate(tip);
      found.push_back(location.point != kNone ? mesh_.triangle_at_point(location.point) : location.triangle);
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
      seeds.add(found[i]);
      for (int k = 0; k < 3; ++k) {
        const TriangleId t = mesh_.welded_neighbour(found[i], k);
        if (t == kNone || !mesh_.is_solid(t)) continue;
        const LatticePoint& at = mesh_.at(mesh_.points(t)[0]);
        const double length = scale_.edge_length(mesh_.lattice().position(at)) / spacing_;
        if (grading.length_at(at) > kGradedReach * length || !seen.add(t)) continue;
        found.push_back(t);
      }
    }
  }

  void report_snapping(CutReport& report) const {
    const InsertionCounts& counts = insertion_.counts();
    report.snapped_points = counts.snapped_points;
    report.closed_gaps = counts.closed_gaps;
    report.widest_gap_m = counts.widest_gap * spacing_;
    report.merged_segments = counts.merged_segments;
  }

  void fill_report(CutOutcome& outcome) const {
    CutReport& report = outcome.report;
    report.pieces = mesh_.num_pieces();
    report.new_vertices = static_cast<std::int32_t>(outcome.edit.added_vertices.size());
    report.moved_vertices = static_cast<std::int32_t>(outcome.edit.moved_vertices.size());
    for (TriangleId t = outcome.undo.num_triangle_slots; t < mesh_.num_triangle_slots(); ++t) {
      report.new_triangles += mesh_.is_solid(t) ? 1 : 0;
    }
    report.removed_vertices = static_cast<std::int32_t>(outcome.edit.removed_vertices.size());
    report.removed_pieces = static_cast<std::int32_t>(outcome.edit.removed_pieces.size());
    report.rewritten_triangles = static_cast<std::int32_t>(outcome.edit.rewritten_triangles.size());
    const InsertionCounts& counts = insertion_.counts();
    report.new_lip_edges = counts.new_lip_edges;
    report_snapping(report);
    report.layers = plan_.layers;
    report.view_deviation_m = plan_.view_deviation_m;
    report.deviation_of_tolerance = deviation_of_tolerance();
    report.deviation_m =
        plan_.view_deviation_m + plan_.curve_deviation_m + (counts.deviation + kRoundingUnits) * spacing_;
    report.quality =
        measure_quality(mesh_, new_triangles(mesh_, outcome.undo, outcome.edit.rewritten_triangles, moved_),
                        plan_.options.min_angle_deg, strand_widths(mesh_, plan_.options));
    const bool is_contract = !is_by_element() && plan_.kept_edges.empty() && plan_.options.min_angle_deg > 0.0;
    if (is_contract && report.quality.triangles_below_contract > 0) {
      report.refinement_stopped = true;
    }
  }

  TriangleMesh& mesh_;
  const CutPlan& plan_;
  PhaseObserver* observer_;
  double spacing_;  // m per lattice unit
  PathScale scale_;
  mesh::MeshEditor editor_;
  OutlineEdges outline_edges_;  // edges of the strip's outline, for a cut with a width
  PathInsertion insertion_;
  std::vector<TriangleId> strip_;                 // triangles of the strip, for a cut with a width
  std::vector<PointId> path_, corridor_, moved_;  // sorted, unique
};

// Returns true if the cut should be tried again with a shorter snap distance. Among dense older lips a path can be
// moved to one lip and from there to the next, farther and farther from its place. It can also run into a corner that
// has no lattice point to round to.
bool needs_less_snapping(const Result<CutOutcome>& outcome) {
  return !outcome.ok() && outcome.error().code == ErrorCode::kFailedPrecondition &&
         outcome.error().reason != "STRIP_COVERS_SHEET";
}

}  // namespace

Result<CutOutcome> apply(TriangleMesh& mesh, const CutPlan& plan, PhaseObserver* observer) {
  if (plan.strokes.empty() && plan.outline.empty()) {
    CutOutcome outcome;
    outcome.report.pieces = mesh.num_pieces();
    outcome.report.triangles_behind = plan.triangles_behind;
    return outcome;
  }
  Result<CutOutcome> outcome = Cutter(mesh, plan, observer).run();
  CutPlan closer = plan;
  for (int attempt = 0; attempt < kCloserAttempts && needs_less_snapping(outcome); ++attempt) {
    closer.snap *= kCloserSnap;
    closer.snap_m = PathScale(mesh, closer.options, closer.snap).mean_snap();
    outcome = Cutter(mesh, closer, observer).run();
  }
#ifdef KERF_VALIDATE
  if (const std::optional<std::string> violation = mesh.find_violation()) {
    KERF_CHECK(false, violation->c_str());
  }
#endif
  return outcome;
}

}  // namespace kerf::cut
