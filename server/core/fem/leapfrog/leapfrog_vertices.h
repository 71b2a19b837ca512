#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/leapfrog/leapfrog_sweep.h"
#include "server/core/linear/lanes16.h"
#include "server/core/mesh/ids.h"

// Access to single vertices in the arrays of a LeapfrogSweep, for the files that define its members.
namespace kerf::fem {

template <typename T>
T* entries(std::vector<linear::Lanes16<T>>& blocks, std::size_t first_block = 0) {
  return blocks.empty() ? nullptr : blocks[first_block].lane.data();
}
template <typename U>
std::array<U*, 3> entries(std::array<std::vector<linear::Lanes16<U>>, 3>& field, std::size_t first_block = 0) {
  return {entries(field[0], first_block), entries(field[1], first_block), entries(field[2], first_block)};
}
template <typename U>
U& at(std::vector<linear::Lanes16<U>>& blocks, std::size_t i) {
  return blocks[i / linear::kBlockLanes].lane[i % linear::kBlockLanes];
}
template <typename U>
const U& at(const std::vector<linear::Lanes16<U>>& blocks, std::size_t i) {
  return blocks[i / linear::kBlockLanes].lane[i % linear::kBlockLanes];
}

template <typename T>
Eigen::Vector3d vector_at(const std::array<std::vector<linear::Lanes16<T>>, 3>& field, mesh::VertexId v) {
  const auto i = static_cast<std::size_t>(v);
  return Eigen::Matrix<T, 3, 1>(at(field[0], i), at(field[1], i), at(field[2], i)).template cast<double>();
}

}  // namespace kerf::fem
