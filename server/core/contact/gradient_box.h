#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Core>

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
class GradientBox {
 public:
  GradientBox() { most_.fill(Eigen::Array4f::Constant(-kInfinity)); }

  void add(const GradientBox& other) {
    for (std::size_t k = 0; k < most_.size(); ++k) most_[k] = most_[k].max(other.most_[k]);
    stray_ = std::max(stray_, other.stray_);
  }
  // Adds a triangle that moves for `duration` (s), with corners that stray by `slack` (m) at most.
  void add(const TriangleShape& triangle, const std::array<const VertexLine*, 3>& corners, float duration, float slack);
  // Returns true if a part without border or lip inside, and all of whose triangles were added, cannot touch itself.
  [[nodiscard]] bool is_flat() const;

 private:
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::array<Eigen::Array4f, 4> most_;  // of both columns, and of their negatives
  float stray_ = 0.0F;                  // -, largest share of a distance that straying takes
};

inline void GradientBox::add(const TriangleShape& triangle, const std::array<const VertexLine*, 3>& corners,
                             float duration, float slack) {
  const std::array<float, 4>& inverse = triangle.inverse_edges;
  const Eigen::Array4f first = corners[1]->x - corners[0]->x, second = corners[2]->x - corners[0]->x;
  const Eigen::Array4f first_way = duration * (corners[1]->v - corners[0]->v);
  const Eigen::Array4f second_way = duration * (corners[2]->v - corners[0]->v);
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Array4f begin = first * inverse[2 * k] + second * inverse[2 * k + 1];
    const Eigen::Array4f end = begin + (first_way * inverse[2 * k] + second_way * inverse[2 * k + 1]);
    most_[k] = most_[k].max(begin.max(end));
    most_[k + 2] = most_[k + 2].max((-begin).max(-end));
  }
  stray_ = std::max(stray_, triangle.stray * slack);
}

inline bool GradientBox::is_flat() const {
  constexpr float kLeast = 0.05F;  // -, share of a distance at rest that must be left
  std::array<Eigen::Vector3f, 2> middle;
  float square = 0.0F;
  for (std::size_t k = 0; k < 2; ++k) {
    middle[k] = (0.5F * (most_[k] - most_[k + 2])).head<3>().matrix();
    square += (0.5F * (most_[k] + most_[k + 2])).head<3>().matrix().squaredNorm();
  }
  const float a = middle[0].squaredNorm(), b = middle[1].squaredNorm(), c = middle[0].dot(middle[1]);
  const float half = 0.5F * (a + b);
  const float least = std::sqrt(std::max(0.0F, half - std::sqrt(0.25F * (a - b) * (a - b) + c * c)));
  const float room = least - kLeast - stray_;
  return room > 0.0F && square <= room * room;
}

}  // namespace kerf::contact
