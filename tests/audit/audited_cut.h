#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "server/core/cut/cut.h"
#include "server/core/cut/fit.h"
#include "tests/audit/cut_audit.h"
#include "tests/audit/path_audit.h"
#include "tests/audit/strip_audit.h"

namespace kerf::audit {

// Holds the outcome of one cut, and the flaw that the checks found in it, if any.
struct AuditedCut {
  enum class End { kApplied, kMissed, kRefused, kInvalid };
  End end = End::kInvalid;
  std::string reason;  // of a refused or invalid cut
  Finding flaw;
  cut::CutPlan plan;
  cut::CutOutcome outcome;  // of an applied or missed cut
};

// Chooses checks in addition to find_cut_flaw(), which always runs.
struct Depth {
  bool violation = false;  // the mesh's own check, find_violation()
  bool undo = false;       // undoing the cut gives the mesh before the cut, bit for bit
  bool reload = false;     // the same cut of a mesh made from the records of the mesh before gives the same hash
  int curve_samples = 0;   // Per piece for find_curve_flaw(), or in all for find_strewn_flaw(); 0: neither runs.
};
inline constexpr Depth kDeepest{true, true, true, 60};

// Returns the curve in its final place, after moving and scaling it by the request's `fit`.
inline cut::Curve placed_curve(const mesh::TriangleMesh& mesh, const cut::CutRequest& request) {
  cut::Curve curve = request.curve;
  if (!request.options.fit) return curve;
  const Eigen::Vector2d margin = cut::kFitMargin * mesh.bounding_box().sizes();
  const cut::Box box = request.options.fit->box.value_or(
      cut::Box{mesh.bounding_box().min() + margin, mesh.bounding_box().max() - margin});
  (void)cut::fit_into(box, curve);  // cannot fail, because plan() has done the same
  return curve;
}

// Runs the checks of `depth` on an applied cut. `curve`: in its final place, see placed_curve().
inline Finding find_flaw_of_applied(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after,
                                    const cut::Curve& curve, const AuditedCut& done, const Depth& depth) {
  if (Finding flaw = find_cut_flaw(before, after, done.plan, done.outcome)) return flaw;
  if (depth.violation) {
    if (Finding flaw = after.find_violation()) return flaw;
  }
  if (depth.curve_samples > 0 && done.plan.options.width_m) {
    const std::uint64_t seed = after.state_hash();
    if (Finding flaw = find_strewn_flaw(before, after, curve, done.plan, done.outcome, seed, depth.curve_samples)) {
      return flaw;
    }
  } else if (depth.curve_samples > 0) {
    if (Finding flaw = find_curve_flaw(before, after, curve, done.outcome.report, depth.curve_samples,
                                       largest_snap(before, done.plan)))
      return flaw;
  }
  if (depth.undo) {
    mesh::TriangleMesh undone = after;
    done.outcome.undo.undo(undone);
    if (Finding flaw = find_difference(before, undone)) return "after undo " + *flaw;
    if (undone.state_hash() != before.state_hash()) return "undo gives another hash";
  }
  if (depth.reload) {
    mesh::TriangleMesh reloaded(before.data());
    if (reloaded.state_hash() != before.state_hash()) return "the mesh read back has another hash";
    const Result<cut::CutOutcome> again = cut::apply(reloaded, done.plan);
    if (!again.ok()) return "refused on the mesh read back: " + again.error().message;
    if (reloaded.state_hash() != after.state_hash()) return "the mesh read back is cut to another hash";
  }
  return std::nullopt;
}

// Checks that a cut was right to miss: strokes within the sheet are dust or follow lips and border, within the
// tolerance or a few snap distances.
inline Finding find_flaw_of_miss(const mesh::TriangleMesh& mesh, const cut::CutPlan& plan) {
  const double tolerance = largest_tolerance(mesh, plan);
  const double snap = std::max(plan.snap_m, 0.1 * tolerance);  // bound of the snap distance anywhere on the sheet
  cut::CutPlan long_strokes = plan;
  std::erase_if(long_strokes.strokes, [&](const cut::Stroke& stroke) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& point : stroke.points) box.extend(point);
    return box.diagonal().norm() <= 3.0 * snap;
  });
  cut::CutReport report;
  report.deviation_m = std::max(tolerance, plan.curve_deviation_m + 3.0 * snap);
  if (Finding gap = find_uncovered_path(mesh, long_strokes, report)) return "missed, but " + *gap;
  return std::nullopt;
}

// Plans `request` on `mesh`, changes the plan by `adjust`, applies it as the server does, and checks the outcome. A cut
// that is not applied must leave the mesh unchanged, bit for bit.
template <typename Adjust>
AuditedCut cut_and_audit(mesh::TriangleMesh& mesh, const cut::CutRequest& request, const Depth& depth,
                         const Adjust& adjust) {
  AuditedCut done;
  const mesh::TriangleMesh before = mesh;
  Result<cut::CutPlan> planned = cut::plan(mesh, request);
  if (!planned.ok()) {
    done.reason = planned.error().reason;
    return done;
  }
  done.plan = std::move(*planned);
  adjust(done.plan);
  Result<cut::CutOutcome> applied = cut::apply(mesh, done.plan);
  if (!applied.ok()) {
    done.end = AuditedCut::End::kRefused;
    done.reason = applied.error().reason;
    done.flaw = find_difference(before, mesh);
    return done;
  }
  done.outcome = std::move(*applied);
  if (done.outcome.status == cut::CutStatus::kNoIntersection) {
    done.end = AuditedCut::End::kMissed;
    done.flaw = find_difference(before, mesh);
    if (!done.flaw && !done.outcome.edit.empty()) done.flaw = "a miss with an edit";
    if (!done.flaw) done.flaw = find_flaw_of_miss(before, done.plan);
    return done;
  }
  done.end = AuditedCut::End::kApplied;
  done.flaw = find_flaw_of_applied(before, mesh, placed_curve(before, request), done, depth);
  return done;
}

inline AuditedCut cut_and_audit(mesh::TriangleMesh& mesh, const cut::CutRequest& request, const Depth& depth = {}) {
  return cut_and_audit(mesh, request, depth, [](cut::CutPlan&) {});
}

}  // namespace kerf::audit
