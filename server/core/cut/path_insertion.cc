#include "server/core/cut/path_insertion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/base/check.h"
#include "server/base/sort_unique.h"
#include "server/core/mesh/lattice_geometry.h"

namespace kerf::cut {

using mesh::kNone;
using mesh::LatticePoint;
using mesh::Location;
using mesh::next_corner;
using mesh::PointId;
using mesh::previous_corner;
using mesh::Recovery;
using mesh::TriangleId;

namespace {

constexpr std::int64_t kMaxLegs = 2'000'000;        // most straight legs of one cut
constexpr std::size_t kMaxSnapNeighbourhood = 512;  // most triangles searched for something to snap to, or for a lip

// Offsets from the lattice point wanted to itself and its neighbours, nearest first. Rounding can put a point outside
// of a very flat triangle; a neighbour may then be inside.
constexpr std::array<std::array<std::int64_t, 2>, 9> kRoundings{
    {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};

Error budget_error() {
  return resource_exhausted("CUT_ELEMENT_BUDGET",
                            "the cut needs more new triangles than allowed; shorten it, or raise max_new_triangles",
                            "cut");
}

Error rounding_error() {
  return failed_precondition("CUT_NOT_REPRESENTABLE",
                             "a point of the cut could not be rounded to a valid position; shift the curve slightly",
                             "cut.curve");
}

// Returns the distance of a place from a segment, lattice units; 0 only if it lies on the segment exactly. The distance
// to a long segment in double precision alone can be rounded to 0.
double unrounded_distance(const LatticePoint& at, const LatticePoint& a, const LatticePoint& b) {
  const double doubled_area = std::abs(mesh::to_double(mesh::doubled_area(a, b, at)));
  return std::max(distance_to_segment(at, a, b), doubled_area / difference(a, b).norm());
}

}  // namespace

PathInsertion::PathInsertion(mesh::MeshEditor& editor, const PathScale& scale, double spacing,
                             OutlineEdges* outline_edges)
    : editor_(editor),
      mesh_(editor.mesh()),
      scale_(scale),
      spacing_(spacing),
      outline_edges_(outline_edges),
      walk_(editor.mesh(), scale),
      trace_(editor.mesh(), scale) {}

void PathInsertion::use_scale_at(const LatticePoint& at) {
  snap_ = scale_.snap_units(at);
}

std::vector<PointId> PathInsertion::path_points() const {
  std::vector<PointId> points = path_points_;
  sort_unique(points);
  return points;
}

std::vector<PointId> PathInsertion::tips() const {
  std::vector<PointId> points = path_points();
  points.erase(std::remove_if(points.begin(), points.end(), [this](PointId p) { return !is_tip(p); }), points.end());
  return points;
}

std::vector<PointId> PathInsertion::corridor_points() const {
  std::vector<PointId> points = corridor_points_;
  sort_unique(points);
  return points;
}

Status PathInsertion::insert(const Stroke& stroke) {
  last_point_ = kNone;
  segment_start_ = segment_end_ = mesh_.lattice().nearest(stroke.points.front());
  KERF_TRY_ASSIGN(PathPosition position, place(segment_start_));
  for (std::size_t i = 1; i < stroke.points.size(); ++i) {
    const LatticePoint end = mesh_.lattice().nearest(stroke.points[i]);
    if (end == segment_end_) continue;
    segment_start_ = segment_end_;
    segment_end_ = end;
    walk_.set_line(segment_start_, segment_end_);
    KERF_TRY(insert_segment(position));
  }
  return Nothing{};
}

Status PathInsertion::split_lone_edges() {
  for (const auto& [p, q] : lip_edges_) {
    int corner = 0;
    const TriangleId t = mesh_.find_edge(p, q, corner);
    if (t == kNone || !is_tip(p) || !is_tip(q)) continue;
    const LatticePoint& a = mesh_.at(p);
    const LatticePoint& b = mesh_.at(q);
    KERF_TRY_ASSIGN(const PointId middle, split_near(t, corner, {(a.x + b.x) / 2, (a.y + b.y) / 2}));
    path_points_.push_back(middle);
    ++counts_.new_lip_edges;
  }
  return Nothing{};
}

// Returns true if exactly one lip edge, and no border edge, meets `point`.
bool PathInsertion::is_tip(PointId point) const {
  std::vector<TriangleId> fan;
  mesh_.fan_around(point, fan);
  return std::count_if(fan.begin(), fan.end(), [&](TriangleId t) {
           return (mesh_.locks(t, next_corner(mesh_.corner_of(t, point))) & mesh::kLocksThatOpen) != 0;
         }) == 1;
}

// Continues the path along the current segment, with points in between, to its end.
Status PathInsertion::insert_segment(PathPosition& position) {
  const Eigen::Vector2d along = difference(segment_start_, segment_end_);
  const mesh::Lattice& lattice = mesh_.lattice();
  bool was_left_out = false;
  for (const double share : scale_.divisions(lattice.position(segment_start_), lattice.spacing * along, spacing_)) {
    const Eigen::Vector2d offset = share * along;
    const LatticePoint at{segment_start_.x + std::llround(offset.x()), segment_start_.y + std::llround(offset.y())};
    if (retrace(position, at) || runs_along_edge(at)) continue;
    was_left_out = !was_left_out && is_near_older_lip(at);
    if (was_left_out) continue;
    KERF_TRY(advance(position, at));
  }
  if (retrace(position, segment_end_)) return Nothing{};
  return advance(position, segment_end_);
}

Status PathInsertion::advance(PathPosition& position, const LatticePoint& at) {
  last_point_ = position.point;
  KERF_TRY_ASSIGN(const PathPosition target, place(at));
  if (target.point != kNone && target.point == position.point) {
    count_merged_segment();
  } else {
    KERF_TRY(run_segment(position, target));
  }
  position = target;
  return Nothing{};
}

void PathInsertion::record_passed_point(PointId point) {
  if (is_on_lip(point)) record_gap(distance_to_path(point));
  record_point(point);
}

// Returns the distance of a point from the current segment, lattice units; 0 only if it lies on the segment exactly.
double PathInsertion::distance_to_path(PointId point) const {
  return unrounded_distance(mesh_.at(point), segment_start_, segment_end_);
}

void PathInsertion::count_merged_segment() {
  ++counts_.merged_segments;
}

// Counts a gap that was closed by moving the path onto a lip or border. `width`: its distance from the path, lattice
// units; 0: the path met it exactly, so there was no gap.
void PathInsertion::record_gap(double width) {
  if (width <= 0.0) return;
  ++counts_.closed_gaps;
  counts_.widest_gap = std::max(counts_.widest_gap, width);
}

// Returns true if an edge runs along the current segment at `at`. The place `at` must be within the snap distance of
// the edge, and both ends of the edge within that of the segment.
bool PathInsertion::runs_along_edge(const LatticePoint& at) const {
  const TriangleId t = mesh_.locate(at, hint_).triangle;
  for (int k = 0; k < 3; ++k) {
    const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
    const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
    if (distance_to_segment(at, a, b) < snap_ && distance_to_segment(a, segment_start_, segment_end_) < snap_ &&
        distance_to_segment(b, segment_start_, segment_end_) < snap_) {
      return true;
    }
  }
  return false;
}

// Returns true if a lip of an earlier cut is closer to `at` than half the spacing. The path gets a point where it
// crosses that lip, and another one so near would only make short edges.
bool PathInsertion::is_near_older_lip(const LatticePoint& at) const {
  const double reach = 0.5 * spacing_ * scale_.edge_length(mesh_.lattice().position(at)) / mesh_.lattice().spacing;
  std::vector<TriangleId> found{mesh_.locate(at, hint_).triangle};
  for (std::size_t i = 0; i < found.size() && i < kMaxSnapNeighbourhood; ++i) {
    const TriangleId t = found[i];
    for (int k = 0; k < 3; ++k) {
      const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
      const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
      if (distance_to_segment(at, a, b) >= reach) continue;
      const mesh::LockBits locks = mesh_.locks(t, k);
      if ((locks & mesh::kLockCut) != 0 && (locks & mesh::kLockFresh) == 0) return true;
      const TriangleId u = mesh_.welded_neighbour(t, k);
      if (u != kNone && std::find(found.begin(), found.end(), u) == found.end()) found.push_back(u);
    }
  }
  return false;
}

// Searches outwards from the triangle that holds the place, across edges within the snap distance. This finds every
// point and edge within that distance.
PathInsertion::Snap PathInsertion::find_snap(const LatticePoint& at, TriangleId start) const {
  Snap best;
  double best_point = snap_;
  double best_edge = snap_;
  std::vector<TriangleId> found{start};
  for (std::size_t i = 0; i < found.size() && i < kMaxSnapNeighbourhood; ++i) {
    const TriangleId t = found[i];
    for (int k = 0; k < 3; ++k) {
      const PointId p = mesh_.points(t)[k];
      const double to_point = difference(mesh_.at(p), at).norm();
      if (to_point < best_point || (to_point == best_point && p < best.point)) {
        best_point = to_point;
        best.point = p;
      }
      const PointId a = mesh_.points(t)[next_corner(k)];
      const PointId b = mesh_.points(t)[previous_corner(k)];
      const double to_edge = distance_to_segment(at, mesh_.at(a), mesh_.at(b));
      if (to_edge >= snap_) continue;
      if (mesh_.is_fixed(t, k) && to_edge < best_edge) {
        best_edge = to_edge;
        best.triangle = t;
        best.corner = k;
      }
      const TriangleId u = mesh_.welded_neighbour(t, k);
      if (u != kNone && std::find(found.begin(), found.end(), u) == found.end()) found.push_back(u);
    }
  }
  return best;
}

Result<PathPosition> PathInsertion::place(const LatticePoint& at) {
  const Location location = mesh_.locate(at, hint_);
  KERF_CHECK(location.kind != Location::Kind::kOutside, "a clipped path stays inside the domain");
  hint_ = location.triangle;
  use_scale_at(at);
  if (location.kind == Location::Kind::kPoint) {
    // A place between the ends of the segment is rounded, so the segment itself may miss this mesh point.
    if (at != segment_end_ && location.point != last_point_) record_passed_point(location.point);
    record_point(location.point);
    return PathPosition{at, location.point, kNone};
  }
  const Snap snap = find_snap(at, location.triangle);
  PointId point = snap.point;
  if (point != kNone) {
    if (point != last_point_ && is_on_lip(point)) record_gap(difference(at, mesh_.at(point)).norm());
    ++counts_.snapped_points;
  } else if (snap.triangle != kNone) {
    const LatticePoint& a = mesh_.at(mesh_.points(snap.triangle)[next_corner(snap.corner)]);
    const LatticePoint& b = mesh_.at(mesh_.points(snap.triangle)[previous_corner(snap.corner)]);
    const LatticePoint foot = rounded_projection(a, b, at);
    const bool is_element_edge = mesh_.locks(snap.triangle, snap.corner) == mesh::kLockOriginal;
    const double gap = unrounded_distance(at, a, b);
    KERF_TRY_ASSIGN(point, split_near(snap.triangle, snap.corner, foot));
    if (foot != at) ++counts_.snapped_points;
    if (!is_element_edge) record_gap(gap);
  } else if (!mesh_.is_solid(location.triangle)) {
    return PathPosition{at, kNone, location.triangle};
  } else {
    KERF_TRY_ASSIGN(point, insert_here(at, location));
  }
  record_deviation(point, difference(at, mesh_.at(point)).norm());
  record_point(point);
  return PathPosition{mesh_.at(point), point, kNone};
}

Result<PointId> PathInsertion::insert_here(const LatticePoint& at, const Location& location) {
  if (location.kind == Location::Kind::kEdge) return split_near(location.triangle, location.corner, at);
  const PointId point = editor_.split_triangle(location.triangle, at);
  if (point == kNone) return editor_.budget_exhausted() ? budget_error() : rounding_error();
  editor_.legalise(point);
  return point;
}

Result<PointId> PathInsertion::split_near(TriangleId t, int corner, const LatticePoint& at) {
  const PointId a = mesh_.points(t)[next_corner(corner)];
  const PointId b = mesh_.points(t)[previous_corner(corner)];
  for (const auto& [dx, dy] : kRoundings) {
    const PointId point = editor_.split_edge(t, corner, {at.x + dx, at.y + dy});
    if (editor_.budget_exhausted()) return budget_error();
    if (point == kNone) continue;
    if (outline_edges_ != nullptr) outline_edges_->split(a, b, point);
    editor_.legalise(point);
    return point;
  }
  return rounding_error();
}

void PathInsertion::record_point(PointId point) {
  path_points_.push_back(point);
  hint_ = mesh_.data().points[static_cast<std::size_t>(point)].triangle;
  record_deviation(point, distance_to_segment(mesh_.at(point), segment_start_, segment_end_));
}

void PathInsertion::record_deviation(PointId point, double distance) {
  if (distance <= 0.0) return;
  counts_.deviation = std::max(counts_.deviation, distance);
  const double of_tolerance = distance * mesh_.lattice().spacing / scale_.tolerance(mesh_.point_position(point));
  counts_.deviation_of_tolerance = std::max(counts_.deviation_of_tolerance, of_tolerance);
}

Status PathInsertion::run_segment(PathPosition from, const PathPosition& to) {
  if (from.point == kNone) from.triangle = mesh_.locate(from.at, from.triangle).triangle;
  std::vector<PathPosition> targets{to};
  while (!targets.empty()) {
    if (++legs_ > kMaxLegs) return budget_error();
    if (follow_lips(from, targets)) continue;
    const PathPosition target = targets.back();
    const Encounter met = walk_.follow(from, target);
    switch (met.kind) {
      case Encounter::Kind::kArrived: {
        if (from.point != kNone && target.point != kNone && runs_through_sheet(met)) {
          KERF_TRY(recover_and_lock_edge(from.point, target.point));
        }
        from = target;
        if (from.point == kNone) from.triangle = met.triangle;
        targets.pop_back();
        break;
      }
      case Encounter::Kind::kPoint: {
        record_passed_point(met.point);
        targets.push_back({mesh_.at(met.point), met.point, kNone});
        break;
      }
      case Encounter::Kind::kFixedEdge: {
        const LatticePoint& a = mesh_.at(mesh_.points(met.triangle)[next_corner(met.corner)]);
        const LatticePoint& b = mesh_.at(mesh_.points(met.triangle)[previous_corner(met.corner)]);
        const LatticePoint crossing = rounded_crossing(from.at, target.at, a, b);
        KERF_TRY_ASSIGN(const PointId split, split_near(met.triangle, met.corner, crossing));
        record_point(split);
        const PathPosition position{mesh_.at(split), split, kNone};
        if (met.solid) {
          targets.push_back(position);
        } else {
          from = position;
        }
        break;
      }
      case Encounter::Kind::kLost:
        return budget_error();
    }
  }
  return Nothing{};
}

bool PathInsertion::runs_through_sheet(const Encounter& arrival) const {
  if (!arrival.edge_exists) return arrival.solid;
  const TriangleId other = mesh_.welded_neighbour(arrival.triangle, arrival.corner);
  return mesh_.is_solid(arrival.triangle) || (other != kNone && mesh_.is_solid(other));
}

Status PathInsertion::recover_and_lock_edge(PointId p, PointId q) {
  const auto& corridor = walk_.corridor();
  corridor_points_.insert(corridor_points_.end(), corridor.begin(), corridor.end());
  const Recovery recovery = editor_.recover_edge(p, q, mesh::kLockRequest);
  if (recovery.status == Recovery::Status::kLimit) return budget_error();
  KERF_CHECK(recovery.status == Recovery::Status::kRecovered, "a leg that was followed to its end can be recovered");
  lock_as_cut(recovery.triangle, recovery.corner);
  if (outline_edges_ != nullptr) outline_edges_->add(p, q);
  return Nothing{};
}

// Returns true if a lip or the border runs through the point.
bool PathInsertion::is_on_lip(PointId point) const {
  return (mesh_.locks_at_point(point) & mesh::kLocksThatOpen) != 0;
}

void PathInsertion::lock_as_cut(TriangleId t, int corner) {
  if ((mesh_.locks(t, corner) & mesh::kLocksThatOpen) != 0) return;
  if (!editor_.lock_edge(t, corner, mesh::kLockCut)) return;
  ++counts_.new_lip_edges;
  lip_edges_.push_back({mesh_.points(t)[next_corner(corner)], mesh_.points(t)[previous_corner(corner)]});
}

}  // namespace kerf::cut
