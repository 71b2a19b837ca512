#include "server/core/cut/path_walk.h"

#include "server/base/check.h"
#include "server/core/mesh/lattice_geometry.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::LatticePoint;
using mesh::next_corner;
using mesh::orient2d;
using mesh::PointId;
using mesh::previous_corner;
using mesh::TriangleId;

namespace {

constexpr int kMaxLegTriangles = 1'000'000;  // most triangles that one leg may cross

Encounter met_point(PointId point, bool solid) {
  return {Encounter::Kind::kPoint, kNone, 0, point, false, solid};
}

}  // namespace

bool PathWalk::holds_end(TriangleId t) const {
  const auto& p = mesh_.points(t);
  for (int k = 0; k < 3; ++k) {
    if (orient2d(mesh_.at(p[next_corner(k)]), mesh_.at(p[previous_corner(k)]), to_.at) < 0) return false;
  }
  return true;
}

bool PathWalk::is_met(PointId v) const {
  if (v == from_.point || v == to_.point) return false;
  const LatticePoint& at = mesh_.at(v);
  const Eigen::Vector2d leg = difference(from_.at, to_.at);
  const double squared_length = leg.squaredNorm();
  const double along = difference(from_.at, at).dot(leg);
  if (along <= 0.0 || along >= squared_length) return false;
  if (squared_distance(from_.at, at) >= squared_length || squared_distance(at, to_.at) >= squared_length) return false;
  const double distance = distance_to_segment(at, from_.at, to_.at);
  const double snap = scale_.snap_units(at);
  return distance < snap && (distance < kRoundingUnits || distance_to_segment(at, line_[0], line_[1]) < snap);
}

bool PathWalk::leave_point(Exit& exit, Encounter& met) {
  mesh_.fan_around(from_.point, fan_);
  for (const TriangleId t : fan_) {
    const int k = mesh_.corner_of(t, from_.point);
    if (to_.point != kNone && mesh_.points(t)[next_corner(k)] == to_.point) {
      met = {Encounter::Kind::kArrived, t, previous_corner(k), kNone, true, mesh_.is_solid(t)};
      return false;
    }
  }
  for (const TriangleId t : fan_) {
    const int k = mesh_.corner_of(t, from_.point);
    const PointId right = mesh_.points(t)[next_corner(k)];
    const PointId left = mesh_.points(t)[previous_corner(k)];
    if (to_.point == kNone && holds_end(t)) {
      met = {Encounter::Kind::kArrived, t, 0, kNone, false, mesh_.is_solid(t)};
      return false;
    }
    const int right_turn = orient2d(from_.at, mesh_.at(right), to_.at);
    if (right_turn == 0 && mesh::dot(from_.at, mesh_.at(right), from_.at, to_.at) > 0) {
      met = met_point(right, mesh_.is_solid(t));
      return false;
    }
    if (right_turn > 0 && orient2d(from_.at, mesh_.at(left), to_.at) < 0) {
      exit = {t, k};
      return true;
    }
  }
  check_failed("fan covers every direction", __FILE__, __LINE__, "a point's fan of triangles is not closed");
}

bool PathWalk::leave_void_triangle(Exit& exit, Encounter& met) const {
  const TriangleId t = from_.triangle;
  if (to_.point == kNone && holds_end(t)) {
    met = {Encounter::Kind::kArrived, t, 0, kNone, false, mesh_.is_solid(t)};
    return false;
  }
  for (int k = 0; k < 3; ++k) {
    if (mesh_.points(t)[k] == to_.point && to_.point != kNone) {
      met = {Encounter::Kind::kArrived, t, 0, kNone, false, mesh_.is_solid(t)};
      return false;
    }
  }
  for (int k = 0; k < 3; ++k) {
    const PointId right = mesh_.points(t)[next_corner(k)];
    const PointId left = mesh_.points(t)[previous_corner(k)];
    const LatticePoint& right_at = mesh_.at(right);
    const int right_turn = orient2d(from_.at, to_.at, right_at);
    if (right_turn == 0 && mesh::dot(from_.at, right_at, from_.at, to_.at) > 0) {
      met = met_point(right, mesh_.is_solid(t));
      return false;
    }
    if (right_turn < 0 && orient2d(from_.at, to_.at, mesh_.at(left)) > 0 &&
        orient2d(right_at, mesh_.at(left), to_.at) < 0) {
      exit = {t, k};
      return true;
    }
  }
  check_failed("leg leaves its triangle", __FILE__, __LINE__, "the path position is not in its triangle");
}

Encounter PathWalk::follow(const PathPosition& from, const PathPosition& to) {
  from_ = from;
  to_ = to;
  corridor_.clear();
  Exit exit;
  Encounter met;
  const bool leaves = from_.point != kNone ? leave_point(exit, met) : leave_void_triangle(exit, met);
  if (!leaves) return met;
  const bool solid = mesh_.is_solid(exit.triangle);
  for (int step = 0; step < kMaxLegTriangles; ++step) {
    const auto [t, k] = exit;
    const PointId right = mesh_.points(t)[next_corner(k)];
    const PointId left = mesh_.points(t)[previous_corner(k)];
    if (is_met(right)) return met_point(right, solid);
    if (is_met(left)) return met_point(left, solid);
    if (mesh_.is_fixed(t, k)) return {Encounter::Kind::kFixedEdge, t, k, kNone, false, solid};
    corridor_.push_back(right);
    corridor_.push_back(left);
    const TriangleId u = mesh_.welded_neighbour(t, k);
    const int j = mesh_.mirror_corner(t, k);
    const PointId apex = mesh_.points(u)[j];
    if (to_.point == kNone ? holds_end(u) : apex == to_.point) {
      return {Encounter::Kind::kArrived, u, 0, kNone, false, solid};
    }
    const int side = orient2d(from_.at, to_.at, mesh_.at(apex));
    if (side == 0 || is_met(apex)) return met_point(apex, solid);
    // In u the crossed edge runs from left (corner j + 1) to right (corner j + 2). If the apex is on the left of the
    // leg, the leg leaves by the edge between right and apex, opposite left.
    exit = {u, side > 0 ? next_corner(j) : previous_corner(j)};
  }
  return {};
}

}  // namespace kerf::cut
