#include "server/core/cut/lip_trace.h"

#include <algorithm>

#include "server/core/mesh/lattice_geometry.h"

namespace kerf::cut {

using mesh::LatticePoint;
using mesh::next_corner;
using mesh::PointId;
using mesh::previous_corner;
using mesh::TriangleId;

namespace {

constexpr std::size_t kMaxVisits = 2048;  // most points visited for one leg

}  // namespace

double LipTrace::distance_to_end(const Visit& visit, const Leg& leg) const {
  return difference(mesh_.at(visit.point), leg.end).norm();
}

bool LipTrace::find(PointId from, const Leg& leg) {
  visit_all(from, leg);
  std::size_t nearest = visits_.size();
  double least = scale_.snap_units(leg.end);
  for (std::size_t i = 0; i < visits_.size(); ++i) {
    const double distance = distance_to_end(visits_[i], leg);
    if (distance >= least) continue;
    least = distance;
    nearest = i;
  }
  if (nearest == visits_.size()) return false;
  take_chain(nearest);
  return true;
}

bool LipTrace::find(PointId from, PointId to, const Leg& leg) {
  visit_all(from, leg);
  for (std::size_t i = 0; i < visits_.size(); ++i) {
    if (visits_[i].point != to) continue;
    take_chain(i);
    return true;
  }
  return false;
}

bool LipTrace::find_border(PointId from, const Leg& leg) {
  visit_all(from, leg);
  std::size_t nearest = 0;
  double least = distance_to_end(visits_.front(), leg);
  for (std::size_t i = 1; i < visits_.size(); ++i) {
    const double distance = distance_to_end(visits_[i], leg);
    if (!visits_[i].on_border || distance >= least) continue;
    least = distance;
    nearest = i;
  }
  if (nearest == 0) return false;
  take_chain(nearest);
  return true;
}

// Visits every point that chains of lips along the leg lead to, breadth first.
void LipTrace::visit_all(PointId from, const Leg& leg) {
  visits_.assign(1, {from, 0, false});
  for (std::size_t i = 0; i < visits_.size() && visits_.size() < kMaxVisits; ++i) visit_neighbours(i, leg);
}

void LipTrace::visit_neighbours(std::size_t of, const Leg& leg) {
  const PointId centre = visits_[of].point;
  mesh_.fan_around(centre, fan_);
  for (const TriangleId t : fan_) {
    const int k = mesh_.corner_of(t, centre);
    // Looks at the edge from the centre to the next corner of t. The fan is closed, so each edge is looked at once.
    const mesh::LockBits locks = mesh_.locks(t, previous_corner(k));
    if ((locks & mesh::kLocksThatOpen) == 0) continue;
    if ((locks & mesh::kLockBorder) != 0) visits_[of].on_border = true;
    const PointId next = mesh_.points(t)[next_corner(k)];
    if (is_along(next, leg) && !was_visited(next)) visits_.push_back({next, of, false});
  }
}

// Uses the largest of three snap distances, since they jump with the local edge length. So a lip that the path snapped
// to at a place with a large snap distance is still followed where that distance is small.
bool LipTrace::is_along(PointId point, const Leg& leg) const {
  const LatticePoint& at = mesh_.at(point);
  return distance_to_segment(at, leg.start, leg.end) <
         std::max({scale_.snap_units(at), scale_.snap_units(leg.start), scale_.snap_units(leg.end)});
}

bool LipTrace::was_visited(PointId point) const {
  return std::any_of(visits_.begin(), visits_.end(), [point](const Visit& v) { return v.point == point; });
}

void LipTrace::take_chain(std::size_t last) {
  chain_.clear();
  for (std::size_t i = last; i != 0; i = visits_[i].came_from) chain_.push_back(visits_[i].point);
  std::reverse(chain_.begin(), chain_.end());
}

}  // namespace kerf::cut
