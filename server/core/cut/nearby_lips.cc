#include "server/core/cut/nearby_lips.h"

#include "server/core/cut/segment_distance.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::TriangleId;

bool NearbyLips::is_on_sheet(const Eigen::Vector2d& at) {
  start_ = kNone;
  if (!mesh_.bounding_box().contains(at)) return false;
  start_ = mesh_.locate(mesh_.lattice().nearest(at)).triangle;
  if (start_ == kNone) return false;
  if (mesh_.is_solid(start_)) return true;
  // On the border the place may belong to a triangle beside the sheet.
  for (int k = 0; k < 3; ++k) {
    const TriangleId other = mesh_.welded_neighbour(start_, k);
    if (other != kNone && mesh_.is_solid(other) &&
        distance_to_segment(at, mesh_.point_position(mesh_.points(start_)[mesh::next_corner(k)]),
                            mesh_.point_position(mesh_.points(start_)[mesh::previous_corner(k)])) <=
            2.0 * mesh_.lattice().spacing) {
      start_ = other;
      return true;
    }
  }
  return false;
}

const std::vector<std::array<Eigen::Vector2d, 2>>& NearbyLips::near(const Eigen::Vector2d& at, double radius) {
  edges_.clear();
  seen_.clear();
  open_.assign(1, start_);
  seen_.insert(start_);
  while (!open_.empty() && budget_ > 0) {
    --budget_;
    const TriangleId t = open_.back();
    open_.pop_back();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d a = mesh_.point_position(mesh_.points(t)[mesh::next_corner(k)]);
      const Eigen::Vector2d b = mesh_.point_position(mesh_.points(t)[mesh::previous_corner(k)]);
      if (distance_to_segment(at, a, b) > radius) continue;
      const TriangleId beyond = mesh_.welded_neighbour(t, k);
      if (mesh_.neighbour(t, k) == kNone) edges_.push_back({a, b});
      if (beyond != kNone && mesh_.is_solid(beyond) && seen_.insert(beyond).second) open_.push_back(beyond);
    }
  }
  if (budget_ <= 0) edges_.clear();
  return edges_;
}

}  // namespace kerf::cut
