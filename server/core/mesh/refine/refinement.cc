#include "server/core/mesh/refine/refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>

#include <Eigen/LU>

#include "server/base/elementary.h"
#include "server/base/interruption.h"
#include "server/core/mesh/lattice_geometry.h"
#include "server/core/mesh/lip_corner.h"
#include "server/core/mesh/refine/straight_walk.h"
#include "server/core/mesh/triangle_shape.h"

namespace kerf::mesh {

using Eigen::Vector2d;

namespace {

constexpr std::size_t kMaxCavity = 256;  // most triangles searched for fixed edges that a new point encroaches on
// Half of Ungor's factor 1, less 5 % as in Shewchuk's Triangle 1.6. The off-centre is a little nearer, so that rounding
// does not leave the new triangle just below the angle.
constexpr double kOffCentreFactor = 0.475;
// Least distance of a new point from a lip that must not be split although the point encroaches on it. It is a fraction
// of the shortest edge of the triangle to remove. -
constexpr double kLeastRoom = 0.3;

// An ill-shaped triangle in the queue. It is stale if the slot holds other corners now.
struct Pending {
  double cos_smallest = 0.0;
  std::int64_t order = 0;
  TriangleId triangle = kNone;
  std::array<PointId, 3> points{};

  // Orders the worst first, and the oldest among equals, so that the order does not depend on the heap.
  friend bool operator<(const Pending& a, const Pending& b) {
    if (a.cos_smallest != b.cos_smallest) return a.cos_smallest < b.cos_smallest;
    return a.order > b.order;
  }
};

}  // namespace

double TipGrading::length_at(const LatticePoint& at) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const LatticePoint& tip : tips) nearest = std::min(nearest, difference(tip, at).norm());
  return length + gradient * nearest;
}

namespace {

double cos_of(double angle_deg) {
  return cosine(angle_deg * std::numbers::pi / 180.0);
}

class Refinement {
 public:
  Refinement(MeshEditor& editor, const RefinementConfig& config)
      : editor_(editor),
        mesh_(editor.mesh()),
        config_(config),
        cos_limit_(cos_of(config.min_angle_deg)),
        cos_strand_limit_(cos_of(config.strand_angle_deg)),
        corners_(editor.mesh()),
        strands_(editor.mesh(), config.strands, config.lengths) {}

  RefinementCounts run(std::span<const TriangleId> seeds) {
    for (const TriangleId t : seeds) {
      interruption_point();
      consider(t);
    }
    process_queue();
    refine_wedges();
    process_queue();
    return counts_;
  }

 private:
  // Stages of refinement, in order. kPlain: all triangles except those that a sharp corner forces. kWedges: those
  // between the lips of sharp corners, except the first at the corner.
  enum class Stage { kPlain, kWedges };

  // A triangle left for a later stage. It is stale if the slot holds other corners now.
  struct Deferred {
    TriangleId triangle = kNone;
    std::array<PointId, 3> points{};
  };

  // Refines between the lips of sharp corners, where triangles must be as narrow as the gap between the lips. Sharper
  // corners need more of them. Their number is bounded, since lip edges that end at the corner are no longer split.
  void refine_wedges() {
    stage_ = Stage::kWedges;
    for (const Deferred& deferred : wedges_) {
      if (mesh_.points(deferred.triangle) == deferred.points) consider(deferred.triangle);
    }
  }

  void process_queue() {
    while (!queue_.empty() && !editor_.budget_exhausted()) {
      interruption_point();
      const Pending next = queue_.top();
      queue_.pop();
      if (mesh_.points(next.triangle) != next.points) continue;
      if (counts_.insertions >= config_.max_insertions) {
        counts_.stopped = true;
        break;
      }
      // Queues the triangle again if it still exists after the insertion.
      if (improve(next.triangle)) consider(next.triangle);
    }
  }

  void consider(TriangleId t) {
    if (!mesh_.is_solid(t)) return;
    const TriangleShape shape = rest_shape_of(mesh_, t);
    if (shape.cos_smallest > cos_limit_ || is_too_large(t, shape))
      queue_.push({shape.cos_smallest, order_++, t, mesh_.points(t)});
  }

  [[nodiscard]] bool is_too_large(TriangleId t, const TriangleShape& shape) const {
    if (config_.grading.tips.empty()) return false;
    const std::array<LatticePoint, 3> at = corners_of(mesh_, t);
    const LatticePoint middle = rounded(at[0], (difference(at[0], at[1]) + difference(at[0], at[2])) / 3.0);
    return shape.longest > std::max(config_.grading.length_at(middle), 4.0 * config_.length_floor);
  }

  // Inserts one point that removes t or brings its removal nearer. Returns false if t must stay as it is.
  bool improve(TriangleId t) {
    const TriangleShape shape = rest_shape_of(mesh_, t);
    const int c = shape.sharpest_corner;
    const double scale = scale_at(mesh_.points(t)[c]);
    if (shape.cos_smallest <= cos_limit_) return insert_against(t, c, shape, cos_limit_);  // well shaped, but too large
    if (shape.shortest <= scale * config_.length_floor) return false;
    if (mesh_.is_fixed(t, next_corner(c)) && mesh_.is_fixed(t, previous_corner(c))) return false;
    const PointId p = mesh_.points(t)[next_corner(c)];
    const PointId q = mesh_.points(t)[previous_corner(c)];
    if (!mesh_.is_fixed(t, c)) {
      const int edges = corners_.edges_to_sharp_corner(p, q);
      if (edges > 0 && stage_ == Stage::kPlain) wedges_.push_back({t, mesh_.points(t)});
      if (edges == 1 || (edges > 1 && stage_ == Stage::kPlain)) return false;
    }
    const Strands::Place place = strands_.place_of(t, shape);
    const double cos_limit = place == Strands::Place::kNear ? cos_strand_limit_ : cos_limit_;
    if (place == Strands::Place::kNarrow) return false;
    return (shape.cos_smallest > cos_limit || is_too_large(t, shape)) && insert_against(t, c, shape, cos_limit);
  }

  // Inserts the off-centre of t for the angle wanted, or splits a fixed edge in its way. Returns false if it can do
  // neither.
  bool insert_against(TriangleId t, int c, const TriangleShape& shape, double cos_angle) {
    const LatticePoint target = off_centre(t, c, cos_angle);
    Location location;
    if (const std::optional<MeshSide> wall = find_wall(mesh_, t, target, location))
      return split_opposite(*wall) || split(*wall);
    if (location.kind == Location::Kind::kOutside) return false;
    if (location.kind == Location::Kind::kPoint) return flip_away(t);
    if (const std::optional<MeshSide> edge = find_encroached(location.triangle, target, kLeastRoom * shape.shortest)) {
      return split(*edge);
    }
    const PointId added = editor_.insert_point(target, location.triangle);
    if (added == kNone) return false;
    settle(added);
    return true;
  }

  // Flips an edge of t that is not Delaunay. Returns true if there was one. Called when the place of the off-centre is
  // already a point, which shows that t is not Delaunay. Sheets as built and moved points can have such edges.
  bool flip_away(TriangleId t) {
    for (int k = 0; k < 3; ++k) {
      if (mesh_.is_fixed(t, k)) continue;
      const TriangleId u = mesh_.welded_neighbour(t, k);
      const PointId across = mesh_.points(u)[mesh_.mirror_corner(t, k)];
      if (!mesh_.is_in_circle(t, mesh_.at(across)) || !editor_.flip_edge(t, k)) continue;
      ++counts_.insertions;
      consider(u);
      return true;
    }
    return false;
  }

  // Returns a point on the bisector of the shortest edge pq: the circumcentre, or a nearer one that is enough for the
  // angle.
  [[nodiscard]] LatticePoint off_centre(TriangleId t, int c, double cos_angle) const {
    const LatticePoint& p = mesh_.at(mesh_.points(t)[next_corner(c)]);
    const LatticePoint& q = mesh_.at(mesh_.points(t)[previous_corner(c)]);
    const LatticePoint& apex = mesh_.at(mesh_.points(t)[c]);
    const Vector2d edge = mesh_.at_rest(t, difference(p, q));
    const Vector2d to_apex = mesh_.at_rest(t, difference(p, apex));
    const Facet* const facet = mesh_.facet(t);
    const double twice_area =
        facet != nullptr ? edge.x() * to_apex.y() - edge.y() * to_apex.x() : to_double(doubled_area(p, q, apex));
    const Vector2d inward(-edge.y(), edge.x());
    // Circumcentre = middle of pq + height * inward, height = (apex - p) . (apex - q) / (2 * doubled area).
    const double circumcentre = to_apex.dot(to_apex - edge) / (2.0 * twice_area);
    const double nearer = kOffCentreFactor * std::sqrt((1.0 + cos_angle) / (1.0 - cos_angle));
    const Vector2d offset = 0.5 * edge + std::min(circumcentre, nearer) * inward;
    return rounded(p, facet != nullptr ? Vector2d(facet->stretch().inverse() * offset) : offset);
  }

  // Returns the factor by which lengths of the configuration scale at p.
  [[nodiscard]] double scale_at(PointId p) const {
    const EdgeLengths& lengths = *config_.lengths;
    return lengths.is_uniform() ? 1.0 : lengths.at(mesh_.point_position(p)) / lengths.mean;
  }

  // Finds the fixed edge that a point at `at` encroaches on most: its diametral circle contains the point deepest.
  // Searches the border of the cavity, which is the triangles whose circumcircles contain the point. Leaves out edges
  // that must not be split and are farther than `room` (lattice units) from the point.
  std::optional<MeshSide> find_encroached(TriangleId start, const LatticePoint& at, double room) {
    std::optional<MeshSide> worst;
    double worst_cos = 0.0;
    cavity_.assign(1, start);
    for (std::size_t i = 0; i < cavity_.size() && i < kMaxCavity; ++i) {
      const TriangleId t = cavity_[i];
      for (int k = 0; k < 3; ++k) {
        if (!mesh_.is_fixed(t, k)) {
          grow_cavity(mesh_.welded_neighbour(t, k), at);
          continue;
        }
        const LatticePoint& a = mesh_.at(mesh_.points(t)[next_corner(k)]);
        const LatticePoint& b = mesh_.at(mesh_.points(t)[previous_corner(k)]);
        const Vector2d to_a = mesh_.at_rest(t, difference(at, a));
        const Vector2d to_b = mesh_.at_rest(t, difference(at, b));
        const double cos_seen = to_a.dot(to_b) / std::sqrt(to_a.squaredNorm() * to_b.squaredNorm());
        if (cos_seen >= worst_cos || (is_frozen({t, k}) && distance_to_segment(at, a, b) > room)) continue;
        worst_cos = cos_seen;
        worst = MeshSide{t, k};
      }
    }
    return worst;
  }

  void grow_cavity(TriangleId t, const LatticePoint& at) {
    if (std::find(cavity_.begin(), cavity_.end(), t) != cavity_.end()) return;
    if (mesh_.is_in_circle(t, at)) cavity_.push_back(t);
  }

  // Splits a fixed edge opposite a point of another lip that faces it across a narrow gap. Splits at the middle would
  // make each new point require one on the other lip, down to the width of the gap. Returns false if no such point
  // faces the edge.
  bool split_opposite(const MeshSide& edge) {
    const PointId facing = mesh_.points(edge.triangle)[edge.corner];
    const LatticePoint& at = mesh_.at(facing);
    const LatticePoint& a = mesh_.at(mesh_.points(edge.triangle)[next_corner(edge.corner)]);
    const LatticePoint& b = mesh_.at(mesh_.points(edge.triangle)[previous_corner(edge.corner)]);
    const double narrow_gap = scale_at(facing) * config_.strands.narrow;
    if (is_frozen(edge) || !mesh_.has_fixed_edge(facing) || distance_to_segment(at, a, b) >= narrow_gap) {
      return false;
    }
    const LatticePoint foot = rounded_projection(a, b, at);
    const double nearest_end = std::min(difference(a, foot).norm(), difference(foot, b).norm());
    if (nearest_end < narrow_gap) return false;
    const PointId added = editor_.split_edge(edge.triangle, edge.corner, foot);
    if (added == kNone) return false;
    settle(added);
    return true;
  }

  // Returns true if a lip must not be split any more because it ends at a sharp corner.
  [[nodiscard]] bool is_frozen(const MeshSide& edge) {
    if (stage_ == Stage::kPlain) return false;
    const auto& p = mesh_.points(edge.triangle);
    return corners_.is_sharp(p[next_corner(edge.corner)]) || corners_.is_sharp(p[previous_corner(edge.corner)]);
  }

  // Splits a fixed edge in its middle, or on a shell around a sharp corner at one of its ends.
  bool split(const MeshSide& edge) {
    const PointId a = mesh_.points(edge.triangle)[next_corner(edge.corner)];
    const PointId b = mesh_.points(edge.triangle)[previous_corner(edge.corner)];
    const double length = difference(mesh_.at(a), mesh_.at(b)).norm();
    if (length <= 2.0 * scale_at(a) * config_.length_floor || is_frozen(edge)) return false;
    const double fraction = corners_.split_fraction(a, b, length);
    const PointId added = editor_.split_edge(edge.triangle, edge.corner, split_place(a, b, fraction, length));
    if (config_.border != nullptr) added == kNone ? config_.border->miss(a, b) : config_.border->add(a, b, added);
    if (added == kNone) return false;
    settle(added);
    return true;
  }

  // Returns the place to split the fixed edge ab, at about `fraction` of its `length` from a. If one end is a sharp
  // corner, the distance from that end is exact.
  [[nodiscard]] LatticePoint split_place(PointId a, PointId b, double fraction, double length) {
    if (config_.border == nullptr) return rounded(mesh_.at(a), fraction * difference(mesh_.at(a), mesh_.at(b)));
    if (fraction != 0.5 && corners_.is_sharp(b)) return config_.border->between(b, a, (1.0 - fraction) * length);
    return config_.border->between(a, b, fraction * length);
  }

  void settle(PointId added) {
    ++counts_.insertions;
    editor_.legalise(added);
    mesh_.fan_around(added, fan_);
    for (const TriangleId t : fan_) consider(t);
  }

  MeshEditor& editor_;
  const TriangleMesh& mesh_;
  RefinementConfig config_;
  double cos_limit_, cos_strand_limit_;
  LipCorners corners_;
  Strands strands_;
  RefinementCounts counts_;
  std::priority_queue<Pending> queue_;
  std::int64_t order_ = 0;
  Stage stage_ = Stage::kPlain;
  std::vector<Deferred> wedges_;
  std::vector<TriangleId> cavity_;
  std::vector<TriangleId> fan_;
};

}  // namespace

RefinementCounts refine(MeshEditor& editor, std::span<const TriangleId> seeds, const RefinementConfig& config) {
  return Refinement(editor, config).run(seeds);
}

}  // namespace kerf::mesh
