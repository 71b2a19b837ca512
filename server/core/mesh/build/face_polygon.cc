#include "server/core/mesh/build/face_polygon.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include <Eigen/Geometry>

#include "server/base/interruption.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/lattice.h"
#include "server/core/mesh/predicates.h"

namespace kerf::mesh {
namespace {

using Triangle = std::array<std::int32_t, 3>;

// Largest tangent of a turn that counts as none while other ears are left.  -; files with few decimals bend straight
// sides by about this much.
constexpr double kNearlyStraight = 1e-3;
constexpr std::size_t kMostFlips = 30;  // for each corner; combs of long teeth would need as many as corners

// Returns the least height of a triangle over its longest edge (-), with the sign of its turn.
double shape_of(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  const double longest = to_double(std::max({dot(a, b, a, b), dot(b, c, b, c), dot(c, a, c, a)}));
  return longest == 0.0 ? 0.0 : to_double(doubled_area(a, b, c)) / longest;
}

// Cuts ears off a counter-clockwise polygon.
class EarCutter {
 public:
  explicit EarCutter(std::span<const LatticePoint> at) : at_(at) {}

  // Returns false if no ear is left although the rest has area: the polygon crosses itself.
  bool run(std::vector<Triangle>& triangles) {
    const auto count = static_cast<std::int32_t>(at_.size());
    for (std::int32_t i = 0; i < count; ++i) {
      previous_.push_back(i == 0 ? count - 1 : i - 1);
      next_.push_back(i + 1 == count ? 0 : i + 1);
      version_.push_back(0);
    }
    offer_all();
    std::int32_t left = count;
    while (left > 2) {
      interruption_point();
      if (ears_.empty() && tolerance_ == 0.0) break;
      if (ears_.empty()) {
        tolerance_ = 0.0;
        offer_all();
        continue;
      }
      const Ear ear = ears_.top();
      ears_.pop();
      if (ear.version != version_[ear.corner] || !is_ear(ear.corner)) continue;
      const std::int32_t a = previous_[ear.corner], c = next_[ear.corner];
      triangles.push_back({a, ear.corner, c});
      next_[a] = c;
      previous_[c] = a;
      version_[ear.corner] = -1;
      --left;
      if (left % 64 == 0) forget_sharp_corners();
      offer(a);
      offer(c);
    }
    return left <= 2 || rest_has_no_area();
  }

 private:
  struct Ear {
    double shape = 0.0;
    std::int32_t corner = 0;
    std::int32_t version = 0;
    // The largest is cut first: the best shape, then the lowest corner.
    friend bool operator<(const Ear& a, const Ear& b) {
      return a.shape != b.shape ? a.shape < b.shape : a.corner > b.corner;
    }
  };

  // Returns true if the border turns right at a corner, or not at all.
  [[nodiscard]] bool is_blunt(std::int32_t i) const {
    const LatticePoint &a = at_[previous_[i]], &b = at_[i], &c = at_[next_[i]];
    const double area = to_double(doubled_area(a, b, c)), along = to_double(dot(a, b, b, c));
    return area <= 0.0 || (along > 0.0 && area <= tolerance_ * along);
  }

  // Puts all corners that are left into the queue and into the list of blunt ones.
  void offer_all() {
    blunt_.clear();
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(at_.size()); ++i) {
      if (version_[i] < 0) continue;
      if (is_blunt(i)) blunt_.push_back(i);
      offer(i);
    }
  }

  // Puts a corner into the queue unless it is blunt; its neighbours have changed.
  void offer(std::int32_t i) {
    ++version_[i];
    if (!is_blunt(i)) ears_.push({shape_of(at_[previous_[i]], at_[i], at_[next_[i]]), i, version_[i]});
  }

  // Returns true if no other corner lies in the triangle of corner i, on its border, or close to its diagonal. Only
  // blunt corners can be there.
  [[nodiscard]] bool is_ear(std::int32_t i) const {
    const LatticePoint &a = at_[previous_[i]], &b = at_[i], &c = at_[next_[i]];
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const auto [low, high] = std::minmax({a.y, b.y, c.y});
    const auto margin = static_cast<std::int64_t>(tolerance_ * static_cast<double>(std::max(right - left, high - low)));
    const double allowed = -tolerance_ * to_double(dot(c, a, c, a));
    return std::none_of(
        blunt_.begin(), blunt_.end(), [&, left = left, right = right, low = low, high = high](std::int32_t j) {
          const LatticePoint& p = at_[j];
          if (p.x < left - margin || p.x > right + margin || p.y < low - margin || p.y > high + margin) return false;
          if (version_[j] < 0 || p == a || p == b || p == c || !is_blunt(j)) return false;
          return orient2d(a, b, p) >= 0 && orient2d(b, c, p) >= 0 && to_double(doubled_area(c, a, p)) >= allowed;
        });
  }

  // Drops corners that were cut off or are blunt no more.
  void forget_sharp_corners() {
    std::erase_if(blunt_, [this](std::int32_t j) { return version_[j] < 0 || !is_blunt(j); });
  }

  [[nodiscard]] bool rest_has_no_area() const {
    const auto left = std::find_if(version_.begin(), version_.end(), [](std::int32_t version) { return version >= 0; });
    const auto start = static_cast<std::int32_t>(left - version_.begin());
    for (std::int32_t i = next_[start]; i != start; i = next_[i]) {
      if (!is_straight(i)) return false;
    }
    return is_straight(start);
  }

  [[nodiscard]] bool is_straight(std::int32_t i) const {
    return orient2d(at_[previous_[i]], at_[i], at_[next_[i]]) == 0;
  }

  std::span<const LatticePoint> at_;
  double tolerance_ = kNearlyStraight;  // 0 once no other ear is left
  std::vector<std::int32_t> previous_;  // of the corners that are left
  std::vector<std::int32_t> next_;
  std::vector<std::int32_t> version_;  // changes with a corner's neighbours; negative: cut off
  std::vector<std::int32_t> blunt_;    // all blunt corners, and some that were
  std::priority_queue<Ear> ears_;
};

// Flips diagonals until the triangles are constrained Delaunay, or kMostFlips are done.
class DiagonalFlips {
 public:
  DiagonalFlips(std::span<const LatticePoint> at, std::vector<Triangle>& triangles) : at_(at), triangles_(triangles) {}

  void run() {
    neighbours_.assign(triangles_.size(), {kNone, kNone, kNone});
    std::vector<std::array<std::int32_t, 4>> sides;  // low corner, high corner, triangle, opposite place
    for (std::int32_t t = 0; t < static_cast<std::int32_t>(triangles_.size()); ++t) {
      for (std::int32_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(triangles_[t][(k + 1) % 3], triangles_[t][(k + 2) % 3]);
        sides.push_back({low, high, t, k});
      }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t i = 1; i < sides.size(); ++i) {
      const auto &a = sides[i - 1], &b = sides[i];
      if (a[0] != b[0] || a[1] != b[1]) continue;
      neighbours_[a[2]][a[3]] = b[2];
      neighbours_[b[2]][b[3]] = a[2];
    }
    for (std::int32_t t = 0; t < static_cast<std::int32_t>(triangles_.size()); ++t) waiting_.push_back(t);
    std::size_t flips_left = kMostFlips * at_.size();
    while (!waiting_.empty() && flips_left > 0) {
      interruption_point();
      const std::int32_t t = waiting_.back();
      waiting_.pop_back();
      for (int k = 0; k < 3; ++k) {
        if (!flip(t, k)) continue;
        --flips_left;
        break;
      }
    }
  }

 private:
  static int place_of(const Triangle& corners, std::int32_t corner) {
    return static_cast<int>(std::find(corners.begin(), corners.end(), corner) - corners.begin());
  }

  // Flips the edge opposite place k of triangle t if the corner beyond it lies in t's circle.
  bool flip(std::int32_t t, int k) {
    const std::int32_t u = neighbours_[t][k];
    if (u == kNone) return false;
    const Triangle ours = triangles_[t], theirs = triangles_[u];
    const std::int32_t a = ours[k], b = ours[(k + 1) % 3], c = ours[(k + 2) % 3];
    const int m = 3 - place_of(theirs, b) - place_of(theirs, c);
    const std::int32_t d = theirs[m];
    if (in_circle(at_[a], at_[b], at_[c], at_[d]) <= 0) return false;
    const std::int32_t beyond_ab = neighbours_[t][(k + 2) % 3], beyond_ca = neighbours_[t][(k + 1) % 3];
    const std::int32_t beyond_bd = neighbours_[u][place_of(theirs, c)], beyond_dc = neighbours_[u][place_of(theirs, b)];
    triangles_[t] = {a, b, d};
    neighbours_[t] = {beyond_bd, u, beyond_ab};
    triangles_[u] = {a, d, c};
    neighbours_[u] = {beyond_dc, beyond_ca, t};
    if (beyond_bd != kNone) std::replace(neighbours_[beyond_bd].begin(), neighbours_[beyond_bd].end(), u, t);
    if (beyond_ca != kNone) std::replace(neighbours_[beyond_ca].begin(), neighbours_[beyond_ca].end(), t, u);
    waiting_.push_back(u);
    waiting_.push_back(t);
    return true;
  }

  std::span<const LatticePoint> at_;
  std::vector<Triangle>& triangles_;
  std::vector<std::array<std::int32_t, 3>> neighbours_;  // across the edge opposite each place
  std::vector<std::int32_t> waiting_;
};

// Returns true if all corners lie within kMinFlatness of the line through the two that are farthest apart.
bool lies_on_a_line(std::span<const LatticePoint> at) {
  const auto far_from = [&](const LatticePoint& from) {
    return *std::max_element(at.begin(), at.end(), [&](const LatticePoint& p, const LatticePoint& q) {
      return dot(from, p, from, p) < dot(from, q, from, q);
    });
  };
  const LatticePoint a = far_from(at[0]), b = far_from(a);
  return std::all_of(at.begin(), at.end(),
                     [&](const LatticePoint& p) { return std::abs(shape_of(a, b, p)) < kMinFlatness; });
}

TriangulatedPolygon triangulate(std::span<const LatticePoint> at) {
  TriangulatedPolygon made;
  if (lies_on_a_line(at)) return made;
  made.kind = PolygonKind::kSound;
  if (at.size() == 3) {
    made.triangles = {{0, 1, 2}};
    return made;
  }
  if (at.size() == 4 && shape_of(at[0], at[1], at[2]) >= kMinFlatness &&
      shape_of(at[0], at[2], at[3]) >= kMinFlatness) {
    made.triangles = {{0, 1, 2}, {0, 2, 3}};
    return made;
  }
  if (!EarCutter(at).run(made.triangles)) {
    made.kind = PolygonKind::kCrossesItself;
    made.triangles.clear();
    return made;
  }
  DiagonalFlips(at, made.triangles).run();
  return made;
}

}  // namespace

TriangulatedPolygon triangulate_polygon(std::span<const Eigen::Vector2d> corners) {
  Eigen::AlignedBox2d box;
  double doubled_sum = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    box.extend(corners[i]);
    const Eigen::Vector2d a = corners[i] - corners[0], b = corners[(i + 1) % corners.size()] - corners[0];
    doubled_sum += a.x() * b.y() - a.y() * b.x();
  }
  if (!(box.sizes().maxCoeff() > 0.0)) return {};
  const Lattice lattice = Lattice::for_bounds(box);
  std::vector<LatticePoint> at;
  at.reserve(corners.size());
  for (const Eigen::Vector2d& corner : corners) at.push_back(lattice.nearest(corner));
  if (doubled_sum >= 0.0) return triangulate(at);
  for (LatticePoint& p : at) p.x = -p.x;  // a mirror image turns counter-clockwise
  return triangulate(at);
}

namespace {

// Returns the longest area vector of a triangle of the first corner, the one farthest from it, and another.
Eigen::Vector3d largest_area(std::span<const Eigen::Vector3d> corners) {
  Eigen::Vector3d far = Eigen::Vector3d::Zero(), area = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& corner : corners) {
    if ((corner - corners[0]).norm() > far.norm()) far = corner - corners[0];
  }
  for (const Eigen::Vector3d& corner : corners) {
    const Eigen::Vector3d candidate = far.cross(corner - corners[0]);
    if (candidate.norm() > area.norm()) area = candidate;
  }
  return area;
}

}  // namespace

std::vector<Eigen::Vector2d> in_own_plane(std::span<const Eigen::Vector3d> corners) {
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    area += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  }
  std::vector<Eigen::Vector2d> plane(corners.size(), Eigen::Vector2d::Zero());
  double size = 0.0;
  for (const Eigen::Vector3d& corner : corners) size = std::max(size, (corner - corners[0]).norm());
  if (!(area.norm() > kMinFlatness * size * size)) area = largest_area(corners);
  const double length = area.norm();
  if (!(length > 0.0)) return plane;
  const Eigen::Vector3d normal = area / length;
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Eigen::Vector3d u = (Eigen::Vector3d::Unit(axis) - normal[axis] * normal).normalized();
  const Eigen::Vector3d v = normal.cross(u);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d offset = corners[i] - corners[0];
    plane[i] = Eigen::Vector2d(u.dot(offset), v.dot(offset));
  }
  return plane;
}

}  // namespace kerf::mesh
