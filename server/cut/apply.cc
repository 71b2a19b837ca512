#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "server/base/check.h"
#include "server/cut/crossed_triangles.h"
#include "server/cut/cut.h"
#include "server/cut/path_insertion.h"
#include "server/cut/refinement.h"
#include "server/cut/relaxation.h"
#include "server/cut/triangle_shape.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::PointId;
using mesh::TriangleId;
using mesh::TriangleMesh;

namespace {

constexpr double kSpacing = 0.8;  // -; longest stretch of path without a point, as a fraction of the edge length

// Refinement steps a cut may take, beyond which the quality is given up, not the cut: per point of the path, and a rest
// for the tips, corners and loops of small cuts. About ten times what was seen.
constexpr std::int64_t kInsertionsPerPathPoint = 60;
constexpr std::int64_t kInsertionsBeside = 2'000;

constexpr double kNarrowGap = 0.03;                    // -; as a fraction of the edge length, see RefinementConfig
constexpr std::int64_t kGapAllowancePerPathPoint = 4;  // triangles
constexpr std::int64_t kGapAllowanceBeside = 600;      // triangles

// Rounding of the strokes to the lattice, and of the points that later split a lip: each at most half a unit in x and
// in y, and a lip is halved fewer than 64 times before the length floor.  lattice units
constexpr double kRoundingUnits = 64.0;

class Cutter {
 public:
  Cutter(TriangleMesh& mesh, const CutPlan& plan)
      : mesh_(mesh),
        plan_(plan),
        spacing_(mesh.lattice().spacing),
        old_solid_(mesh.num_solid_triangles()),
        editor_(mesh, slot_limit(mesh, plan)),
        insertion_(editor_, plan.snap_m / spacing_, kSpacing * plan.edge_length_m / spacing_) {}

  Result<CutOutcome> run() {
    CutOutcome outcome;
    outcome.report.triangles_behind = plan_.triangles_behind;
    outcome.report.crossed_triangles = count_crossed_triangles(mesh_, plan_.strokes);
    for (const Stroke& stroke : plan_.strokes) {
      if (Status status = insertion_.insert(stroke); !status.ok()) return status.error();
    }
    if (insertion_.counts().new_lip_edges == 0) {
      editor_.rollback();
      outcome.report.pieces = mesh_.num_pieces();
      return outcome;
    }
    if (Status status = insertion_.split_lone_edges(); !status.ok()) return status.error();
    path_ = insertion_.path_points();
    corridor_ = insertion_.corridor_points();
    if (plan_.options.relax) relax_ring();
    if (plan_.options.min_angle_deg > 0.0) {
      const Result<RefinementCounts> refined = refine_neighbourhood();
      if (!refined.ok()) return refined.error();
      outcome.report.refinement_stopped = refined->stopped;
    }
    editor_.open();
    if (mesh_.num_vertices() > plan_.options.max_vertices) return too_many_vertices();
    mesh::CommittedEdit committed = editor_.commit();
    outcome.status = CutStatus::kApplied;
    outcome.edit = std::move(committed.edit);
    outcome.undo = std::move(committed.undo);
    fill_report(outcome);
    return outcome;
  }

 private:
  static std::int32_t slot_limit(const TriangleMesh& mesh, const CutPlan& plan) {
    const std::int64_t wanted = mesh.num_triangle_slots() + plan.options.max_new_triangles;
    return static_cast<std::int32_t>(std::min<std::int64_t>(wanted, mesh::MeshEditor::kDefaultMaxSlots));
  }

  [[nodiscard]] Error too_many_vertices() const {
    return {ErrorCode::kResourceExhausted, "TOO_MANY_VERTICES",
            "the cut would leave the sheet with " + std::to_string(mesh_.num_vertices()) + " vertices; its limit is " +
                std::to_string(plan_.options.max_vertices) + "; shorten the cut, or start from a coarser mesh",
            "cut"};
  }

  [[nodiscard]] bool on_path(PointId p) const { return std::binary_search(path_.begin(), path_.end(), p); }
  [[nodiscard]] bool in_corridor(PointId p) const {
    return on_path(p) || std::binary_search(corridor_.begin(), corridor_.end(), p);
  }

  // Solid triangles that inserting the path has rewritten: those with a corner on it, and those made in a corridor that
  // was cleared for it.
  [[nodiscard]] std::vector<TriangleId> touched_triangles() const {
    std::vector<TriangleId> touched;
    std::vector<TriangleId> fan;
    const auto collect = [&](PointId centre, bool all) {
      mesh_.fan_around(centre, fan);
      for (const TriangleId t : fan) {
        const auto& p = mesh_.points(t);
        if (!mesh_.is_solid(t)) continue;
        if (all || (in_corridor(p[0]) && in_corridor(p[1]) && in_corridor(p[2]))) touched.push_back(t);
      }
    };
    for (const PointId p : path_) collect(p, true);
    for (const PointId p : corridor_) collect(p, false);
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    return touched;
  }

  void relax_ring() {
    std::vector<PointId> candidates;
    for (const TriangleId t : touched_triangles()) {
      for (const PointId p : mesh_.points(t)) {
        if (!editor_.is_new(p) && !on_path(p)) candidates.push_back(p);
      }
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    moved_ = relax(editor_, candidates, plan_.fixed_vertices);
  }

  Result<RefinementCounts> refine_neighbourhood() {
    std::vector<TriangleId> seeds = touched_triangles();
    std::vector<TriangleId> fan;
    for (const PointId p : moved_) {
      mesh_.fan_around(p, fan);
      seeds.insert(seeds.end(), fan.begin(), fan.end());
    }
    std::sort(seeds.begin(), seeds.end());
    seeds.erase(std::unique(seeds.begin(), seeds.end()), seeds.end());
    RefinementConfig config;
    config.min_angle_deg = plan_.options.min_angle_deg;
    config.length_floor = 0.25 * plan_.snap_m / spacing_;
    const auto path_size = static_cast<std::int64_t>(path_.size());
    config.narrow_gap = kNarrowGap * plan_.edge_length_m / spacing_;
    config.gap_allowance = kGapAllowanceBeside + kGapAllowancePerPathPoint * path_size;
    config.max_insertions = kInsertionsBeside + kInsertionsPerPathPoint * path_size;
    return refine(editor_, seeds, config);
  }

  void fill_report(CutOutcome& outcome) const {
    CutReport& report = outcome.report;
    report.pieces = mesh_.num_pieces();
    report.new_vertices = static_cast<std::int32_t>(outcome.edit.added_vertices.size());
    report.moved_vertices = static_cast<std::int32_t>(outcome.edit.moved_vertices.size());
    report.new_triangles = mesh_.num_solid_triangles() - old_solid_;
    report.rewritten_triangles = static_cast<std::int32_t>(outcome.edit.rewritten_triangles.size());
    const InsertionCounts& counts = insertion_.counts();
    report.new_lip_edges = counts.new_lip_edges;
    report.snapped_points = counts.snapped_points;
    report.closed_gaps = counts.closed_gaps;
    report.merged_segments = counts.merged_segments;
    report.layers = plan_.layers;
    report.deviation_m = plan_.curve_deviation_m + (counts.deviation + kRoundingUnits) * spacing_;
    fill_shapes(outcome.edit.rewritten_triangles, report);
  }

  void fill_shapes(const std::vector<TriangleId>& rewritten, CutReport& report) const {
    const double to_degrees = 180.0 / std::numbers::pi;
    double cos_smallest = -1.0;
    double smallest_height = std::numeric_limits<double>::infinity();
    const double cos_limit = std::cos(plan_.options.min_angle_deg / to_degrees);
    for (const TriangleId t : rewritten) {
      if (!mesh_.is_solid(t)) continue;
      const TriangleShape shape = shape_of(corners_of(mesh_, t));
      cos_smallest = std::max(cos_smallest, shape.cos_smallest);
      smallest_height = std::min(smallest_height, shape.smallest_height);
      report.max_aspect = std::max(report.max_aspect, shape.longest / shape.smallest_height);
      if (shape.cos_smallest > cos_limit) ++report.triangles_below_angle;
    }
    report.min_angle_deg = std::acos(std::min(cos_smallest, 1.0)) * to_degrees;
    report.min_height_m = smallest_height * spacing_;
  }

  TriangleMesh& mesh_;
  const CutPlan& plan_;
  double spacing_;  // m a lattice unit
  std::int32_t old_solid_;
  mesh::MeshEditor editor_;
  PathInsertion insertion_;
  std::vector<PointId> path_, corridor_, moved_;  // sorted, unique
};

}  // namespace

Result<CutOutcome> apply(TriangleMesh& mesh, const CutPlan& plan) {
  if (plan.strokes.empty()) {
    CutOutcome outcome;
    outcome.report.pieces = mesh.num_pieces();
    outcome.report.triangles_behind = plan.triangles_behind;
    return outcome;
  }
  Result<CutOutcome> outcome = Cutter(mesh, plan).run();
#ifdef KERF_VALIDATE
  if (const std::optional<std::string> violation = mesh.find_violation()) {
    KERF_CHECK(false, violation->c_str());
  }
#endif
  return outcome;
}

}  // namespace kerf::cut
