#include "server/core/mesh/strands.h"

#include <algorithm>
#include <cmath>

#include "server/core/mesh/lattice_geometry.h"

namespace kerf::mesh {

using Eigen::Vector2d;

namespace {

// Two lips face each other if their nearest places lie at least 150 degrees apart, seen from the middle of the edge.
// The lips of a corner of up to 30 degrees do so; LipCorners handles wider corners.
constexpr double kCosFacing = -0.866;   // -
constexpr int kCutsOfCrossing = 3;      // least number of cut edges at a point where one cut meets another
constexpr std::size_t kMaxFound = 256;  // most triangles searched for strands
constexpr double kOnEdge = 2.0;         // lattice units; a place this near to the middle of the edge lies on that edge

}  // namespace

Strands::Place Strands::place_of(TriangleId t, const TriangleShape& shape) {
  if (widths_.near <= 0.0) return Place::kElsewhere;
  const int c = shape.sharpest_corner;
  const auto& p = mesh_.points(t);
  const double scale = lengths_->is_uniform() ? 1.0 : lengths_->at(mesh_.point_position(p[c])) / lengths_->mean;
  if (shape.shortest < scale * widths_.narrow && !mesh_.is_fixed(t, c) && mesh_.has_fixed_edge(p[next_corner(c)]) &&
      mesh_.has_fixed_edge(p[previous_corner(c)])) {
    return Place::kNarrow;
  }
  return has_strands(t, c, scale * widths_.near) ? Place::kNear : Place::kElsewhere;
}

// Searches the triangles reached from t across edges that are not fixed and come within `reach` of the middle of the
// edge.
bool Strands::has_strands(TriangleId t, int c, double reach) {
  const LatticePoint& p = mesh_.at(mesh_.points(t)[next_corner(c)]);
  const Vector2d edge = difference(p, mesh_.at(mesh_.points(t)[previous_corner(c)]));
  const Vector2d normal = mesh_.at_rest(t, edge).unitOrthogonal();
  const auto from_middle = [&](PointId q) { return mesh_.at_rest(t, difference(p, mesh_.at(q)) - 0.5 * edge); };
  reach_ = reach;
  ends_.clear();
  feet_.clear();
  found_.assign(1, t);
  for (std::size_t i = 0; i < found_.size() && i < kMaxFound; ++i) {
    for (int k = 0; k < 3; ++k) {
      const PointId right = mesh_.points(found_[i])[next_corner(k)];
      const PointId left = mesh_.points(found_[i])[previous_corner(k)];
      const Vector2d a = from_middle(right);
      const Vector2d b = from_middle(left);
      const double share = -a.dot(b - a) / (b - a).squaredNorm();
      Vector2d foot = a + std::clamp(share, 0.0, 1.0) * (b - a);
      if (foot.squaredNorm() >= reach * reach) continue;
      if (!mesh_.is_fixed(found_[i], k)) {
        const TriangleId u = mesh_.welded_neighbour(found_[i], k);
        if (std::find(found_.begin(), found_.end(), u) == found_.end()) found_.push_back(u);
      } else if ((mesh_.locks(found_[i], k) & kLocksThatOpen) != 0) {
        if (record_end(right, a) || record_end(left, b)) return true;
        if (share <= 0.0 || share >= 1.0) continue;
        if (foot.norm() < kOnEdge) foot = -normal;
        if (record_foot(foot)) return true;
      }
    }
  }
  return false;
}

bool Strands::record_end(PointId p, const Vector2d& offset) {
  if (offset.norm() >= reach_ || std::find(ends_.begin(), ends_.end(), p) != ends_.end()) return false;
  ends_.push_back(p);
  int num_cuts = 0;
  bool is_nearest = true;
  mesh_.fan_around(p, fan_);
  for (const TriangleId t : fan_) {
    const int k = mesh_.corner_of(t, p);
    const LockBits locks = mesh_.locks(t, previous_corner(k));
    if ((locks & kLocksThatOpen) == 0) continue;
    if ((locks & kLockCut) != 0) ++num_cuts;
    const Vector2d along =
        mesh_.at_rest(found_.front(), difference(mesh_.at(p), mesh_.at(mesh_.points(t)[next_corner(k)])));
    if (offset.dot(along) < 0.0) is_nearest = false;
  }
  if (num_cuts >= kCutsOfCrossing) return true;
  return is_nearest && record_foot(offset);
}

bool Strands::record_foot(const Vector2d& foot) {
  const double distance = foot.norm();
  for (const Vector2d& other : feet_) {
    if (distance + other.norm() < reach_ && foot.dot(other) <= kCosFacing * distance * other.norm()) return true;
  }
  feet_.push_back(foot);
  return false;
}

}  // namespace kerf::mesh
