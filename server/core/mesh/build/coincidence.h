#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace kerf::mesh {

// Groups points that lie at most `tolerance` apart, directly or through others, and returns the lowest index of each
// point's group. Points that are not finite stay alone. `tolerance`: >= 0.
std::vector<std::int32_t> first_at_place(std::span<const Eigen::Vector3d> points, double tolerance);

// Returns a number that is the same for connected indices: the lowest of each group. Joins are given in any order.
class Groups {
 public:
  explicit Groups(std::size_t count);
  void join(std::int32_t a, std::int32_t b);
  [[nodiscard]] std::int32_t first_of(std::int32_t a);

 private:
  std::vector<std::int32_t> parent_;
};

}  // namespace kerf::mesh
