// The part of PathInsertion that runs the path along existing lips instead of cutting beside them.
#include <algorithm>

#include "server/core/cut/path_insertion.h"
#include "server/core/mesh/lattice_geometry.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::LatticePoint;
using mesh::Location;
using mesh::PointId;

// Runs the path along existing lips or the border, from `position` to the point nearest to `at` within the snap
// distance. If a mesh point lies exactly at `at`, they must lead to that point. Returns false and changes nothing if
// none lead there.
bool PathInsertion::retrace(PathPosition& position, const LatticePoint& at) {
  if (position.point == kNone) return false;
  const Location location = mesh_.locate(at, hint_);
  const LipTrace::Leg leg = leg_to(position.at, at);
  const bool found = location.kind == Location::Kind::kPoint ? trace_.find(position.point, location.point, leg)
                                                             : trace_.find(position.point, leg);
  if (!found) return false;
  run_along_chain(position.point);
  if (!trace_.chain().empty()) position = {mesh_.at(trace_.chain().back()), trace_.chain().back(), kNone};
  // If the chain does not reach `at`, the rest of the segment is shorter than the snap distance and counts as merged.
  const LatticePoint reached = mesh::rounded_projection(segment_start_, segment_end_, position.at);
  if (trace_.chain().empty() || reached != at) count_merged_segment();
  if (position.at != at) ++counts_.snapped_points;
  record_deviation(position.point, difference(at, position.at).norm());
  return true;
}

// Runs the leg from `from` to the last of `targets`, or its part inside the sheet, along existing lips. If there are
// such lips, it moves `from` to the end that they reach, removes the target if it is there, and returns true. A leg
// that starts in the void is only traced, backwards from its end. The border point that the trace finds is appended to
// `targets`, so that it is reached first, and the result is false.
bool PathInsertion::follow_lips(PathPosition& from, std::vector<PathPosition>& targets) {
  const PathPosition target = targets.back();
  if (from.point == kNone) {
    if (target.point == kNone || !trace_.find_border(target.point, leg_to(target.at, from.at))) return false;
    const PointId entry = trace_.chain().back();
    record_passed_point(entry);
    targets.push_back({mesh_.at(entry), entry, kNone});
    return false;
  }
  const LipTrace::Leg leg = leg_to(from.at, target.at);
  if (!(target.point == kNone ? trace_.find_border(from.point, leg) : trace_.find(from.point, target.point, leg))) {
    return false;
  }
  run_along_chain(from.point);
  if (target.point != kNone) {
    from = target;
    targets.pop_back();
  } else {
    from = {mesh_.at(trace_.chain().back()), trace_.chain().back(), kNone};
  }
  return true;
}

// Returns the part of the current segment between the projections of two places. So a place that was moved onto a lip
// does not lead to lips that are even farther from the path.
LipTrace::Leg PathInsertion::leg_to(const LatticePoint& from, const LatticePoint& to) const {
  return {mesh::rounded_projection(segment_start_, segment_end_, from),
          mesh::rounded_projection(segment_start_, segment_end_, to)};
}

void PathInsertion::run_along_chain(PointId from) {
  double widest = 0.0;
  for (const PointId next : trace_.chain()) {
    if (outline_edges_ != nullptr) outline_edges_->add(from, next);
    record_point(next);
    widest = std::max(widest, distance_to_path(next));
    from = next;
  }
  record_gap(widest);
}

}  // namespace kerf::cut
