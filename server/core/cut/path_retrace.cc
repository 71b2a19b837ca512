// Implements the part of PathInsertion that leads the path along existing lips instead of cutting beside them.
#include <algorithm>

#include "server/core/cut/path_insertion.h"
#include "server/core/mesh/lattice_geometry.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::LatticePoint;
using mesh::Location;
using mesh::PointId;

// Follows existing lips, or the border, from `position` to the point nearest to `at` within the snap distance. If a
// point of the mesh lies exactly at `at`, they must lead to that one. Returns false, and changes nothing, if none lead
// there.
bool PathInsertion::retrace(PathPosition& position, const LatticePoint& at) {
  if (position.point == kNone) return false;
  const Location location = mesh_.locate(at, hint_);
  const LipTrace::Leg leg = leg_to(position.at, at);
  const bool found = location.kind == Location::Kind::kPoint ? trace_.find(position.point, location.point, leg)
                                                             : trace_.find(position.point, leg);
  if (!found) return false;
  run_along_chain(position.point);
  if (!trace_.chain().empty()) position = {mesh_.at(trace_.chain().back()), trace_.chain().back(), kNone};
  // Counts the rest of the segment, or all of it, as merged.
  const LatticePoint reached = mesh::rounded_projection(segment_start_, segment_end_, position.at);
  if (trace_.chain().empty() || reached != at) count_merged_segment();
  if (position.at != at) ++counts_.snapped_points;
  record_deviation(position.point, difference(at, position.at).norm());
  return true;
}

// Leads a leg, or the part of it inside the sheet, along existing lips. Traces a leg from the void backwards from its
// end: the point where it enters the sheet becomes the next target, and the result is false.
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

// Returns the part of the current segment between the projections of two places. So places that were moved onto lips do
// not lead to lips farther away.
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
