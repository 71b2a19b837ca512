#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include <Eigen/Core>

#include "server/base/elementary.h"
#include "server/core/mesh/ids.h"

namespace kerf::contact {

// A vertex in straight motion, in floats relative to the sheet; the fourth entries are not used.
struct VertexLine {
  Eigen::Array4f x = Eigen::Array4f::Zero();  // m
  Eigen::Array4f v = Eigen::Array4f::Zero();  // m/s
};

// Corners of a triangle and its shape at rest, which its deformation gradient follows from.
struct TriangleShape {
  std::array<mesh::VertexId, 3> vertices{};
  std::array<float, 4> inverse_edges{};  // 1/m, by column: inverse of the material edges from corner 0
  float stray = 0.0F;                    // 1/m: share of its altitude that it loses for each metre of slack
};

// An axis-parallel box around the deformation gradients F (3 x 2) of some triangles during a straight motion.
//
// Let |F - F0| <= rho for all triangles that cover a convex part of the material plane. Then |x(A) - x(B)| >=
// (sigma_min(F0) - rho) |A - B| for any two of its points, as x(B) - x(A) is the integral of F (B - A). F0 is the
// middle of the box, and rho half its diagonal. F moves straight too, so that both ends of the motion are enough.
// A bent part often has no such F0. It is enough that each direction d has a unit vector w with w . F d >= lambda.
class GradientBox {
 public:
  GradientBox() { most_.fill(Eigen::Array4f::Constant(-kInfinity)); }

  void add(const GradientBox& other) {
    for (std::size_t k = 0; k < most_.size(); ++k) most_[k] = most_[k].max(other.most_[k]);
    stray_ = std::max(stray_, other.stray_);
  }
  // Adds a triangle that moves from `begin` to `end` (s), with corners that stray by `slack` (m) at most.
  void add(const TriangleShape& triangle, const std::array<const VertexLine*, 3>& corners, float begin, float end,
           float slack);
  // Returns true if a part without border or lip inside, and all of whose triangles were added, cannot touch itself.
  [[nodiscard]] bool is_flat() const;

 private:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::array<Eigen::Array4f, 4> most_;  // of both columns, and of their negatives
  float stray_ = 0.0F;                  // -, largest share of a distance that straying takes
};

inline void GradientBox::add(const TriangleShape& triangle, const std::array<const VertexLine*, 3>& corners,
                             float begin, float end, float slack) {
  const std::array<float, 4>& inverse = triangle.inverse_edges;
  const Eigen::Array4f first_v = corners[1]->v - corners[0]->v, second_v = corners[2]->v - corners[0]->v;
  const Eigen::Array4f first = corners[1]->x - corners[0]->x + begin * first_v;
  const Eigen::Array4f second = corners[2]->x - corners[0]->x + begin * second_v;
  const Eigen::Array4f first_way = (end - begin) * first_v, second_way = (end - begin) * second_v;
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Array4f from = first * inverse[2 * k] + second * inverse[2 * k + 1];
    const Eigen::Array4f to = from + (first_way * inverse[2 * k] + second_way * inverse[2 * k + 1]);
    most_[k] = most_[k].max(from.max(to));
    most_[k + 2] = most_[k + 2].max((-from).max(-to));
  }
  stray_ = std::max(stray_, triangle.stray * slack);
}

inline bool GradientBox::is_flat() const {
  constexpr float kLeast = 0.05F;  // -, share of a distance at rest that must be left
  std::array<Eigen::Vector3f, 2> middle, half;
  for (std::size_t k = 0; k < 2; ++k) {
    middle[k] = (0.5F * (most_[k] - most_[k + 2])).head<3>().matrix();
    half[k] = (0.5F * (most_[k] + most_[k + 2])).head<3>().matrix();
  }
  const float a = middle[0].squaredNorm(), b = middle[1].squaredNorm(), c = middle[0].dot(middle[1]);
  const float mean = 0.5F * (a + b);
  const float least = std::sqrt(std::max(0.0F, mean - std::sqrt(0.25F * (a - b) * (a - b) + c * c)));
  const float room = least - kLeast - stray_;
  if (!(room > 0.0F)) return false;
  if (half[0].squaredNorm() + half[1].squaredNorm() <= room * room) return true;
  // F d leaves a plane through 0 behind for each direction d of a sector if it does so at both ends: the least of
  // w . F d over the box, w . F0 d - |w| . (half |d|), is linear there.
  constexpr std::size_t kSectors = 8;  // of half a turn
  static const std::array<Eigen::Array2f, kSectors + 1> kEnds = [] {
    std::array<Eigen::Array2f, kSectors + 1> ends;
    for (std::size_t k = 0; k <= kSectors; ++k) {
      const double angle = std::numbers::pi * static_cast<double>(k) / kSectors;
      ends[k] = Eigen::Array2d(cosine(angle), sine(angle)).cast<float>();
    }
    return ends;
  }();
  Eigen::Vector3f from = middle[0];  // F0 d
  for (std::size_t k = 0; k < kSectors; ++k) {
    const Eigen::Vector3f to = kEnds[k + 1].x() * middle[0] + kEnds[k + 1].y() * middle[1];
    const Eigen::Vector3f w = (from + to).normalized();
    const Eigen::Array2f lost(w.cwiseAbs().dot(half[0]), w.cwiseAbs().dot(half[1]));
    const float at_from = w.dot(from) - (lost * kEnds[k].abs()).sum();
    const float at_to = w.dot(to) - (lost * kEnds[k + 1].abs()).sum();
    if (!(std::min(at_from, at_to) > kLeast + stray_)) return false;
    from = to;
  }
  return true;
}

}  // namespace kerf::contact
