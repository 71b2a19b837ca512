#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include "server/fem/lanes16.h"
#include "server/fem/leapfrog_sweep.h"
#include "server/mesh/ids.h"

// Single vertices in the arrays of a LeapfrogSweep, for the files that its members are defined in.
namespace kerf::fem {

template <typename T>
T* entries(std::vector<Lanes16<T>>& blocks, std::size_t first_block = 0) {
  return blocks.empty() ? nullptr : blocks[first_block].lane.data();
}
template <typename U>
std::array<U*, 3> entries(std::array<std::vector<Lanes16<U>>, 3>& field, std::size_t first_block = 0) {
  return {entries(field[0], first_block), entries(field[1], first_block), entries(field[2], first_block)};
}
template <typename U>
U& at(std::vector<Lanes16<U>>& blocks, std::size_t i) {
  return blocks[i / kBlockLanes].lane[i % kBlockLanes];
}
template <typename U>
const U& at(const std::vector<Lanes16<U>>& blocks, std::size_t i) {
  return blocks[i / kBlockLanes].lane[i % kBlockLanes];
}

template <typename T>
Eigen::Vector3d vector_at(const std::array<std::vector<Lanes16<T>>, 3>& field, mesh::VertexId v) {
  const auto i = static_cast<std::size_t>(v);
  return Eigen::Matrix<T, 3, 1>(at(field[0], i), at(field[1], i), at(field[2], i)).template cast<double>();
}

// Moves single vertices as leapfrog_kernels.cc does.
template <typename T>
class LeapfrogSweep<T>::VertexChange {
 public:
  explicit VertexChange(LeapfrogSweep& sweep)
      : v_(entries(sweep.v_)),
        v_remainder_(entries(sweep.v_remainder_)),
        x_(entries(sweep.x_, 3 * sweep.pad_)),
        remainder_(entries(sweep.remainder_)),
        corner_x_(entries(sweep.corner_x_)) {}
  [[nodiscard]] T velocity(std::size_t i, std::size_t c) const { return v_[c][i]; }
  // Velocity by `change`, m/s, and position as far as that takes it: drift in s / unit. Returns the velocity.
  T add(std::size_t i, std::size_t c, T change, T drift) const {
    T& v = v_[c][i];
    Position& x = x_[c][i];
    if constexpr (std::is_same_v<T, float>) {
      const float all_of_v = change + v_remainder_[c][i];
      const float after = v + all_of_v;
      v_remainder_[c][i] = all_of_v - (after - v);
      v = after;
      const float all = drift * change + remainder_[c][i];
      const auto whole = static_cast<std::int32_t>(std::lrint(all));
      remainder_[c][i] = all - static_cast<float>(whole);
      x = static_cast<std::int32_t>(static_cast<std::uint32_t>(x) + static_cast<std::uint32_t>(whole));  // may wrap
    } else {
      v += change;
      x += drift * change;
    }
    corner_x_[4 * i + c] = x;
    return v;
  }

 private:
  std::array<T*, 3> v_, v_remainder_;
  std::array<Position*, 3> x_;
  std::array<T*, 3> remainder_;
  Position* corner_x_;
};

}  // namespace kerf::fem
