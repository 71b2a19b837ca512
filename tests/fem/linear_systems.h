#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/block_matrix.h"
#include "tests/fem/fixture.h"
#include "tests/support/meshes.h"

namespace kerf::fem {

struct System {
  linear::BlockMatrix A;
  Eigen::MatrixXd dense;
};

// M + scale K on a random planar pattern: the edges of a mesh, 3x3 blocks, positive definite by construction
// (sum over edges of u u^T plus a positive diagonal).
inline System random_system(int side, double scale, std::uint64_t seed) {
  const mesh::TriangleMesh mesh = jittered_square(side);
  const int n = mesh.num_vertices();
  std::vector<std::vector<int>> columns(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    std::vector<int>& row = columns[static_cast<std::size_t>(i)];
    row = test::one_ring(mesh, i);
    row.push_back(i);
    std::sort(row.begin(), row.end());
  }
  System system;
  system.A.resize(n);
  for (int i = 0; i < n; ++i) system.A.set_row(i, columns[static_cast<std::size_t>(i)]);
  system.A.set_zero();
  SeededRandom random(seed);
  for (int i = 0; i < n; ++i) {
    system.A.block(system.A.diagonal(i)).diagonal().array() += random.uniform(0.5, 2.0);
    for (const int j : columns[static_cast<std::size_t>(i)]) {
      if (j <= i) continue;
      const Eigen::Vector3d u = random_vector(random, 1.0);
      const Eigen::Vector3d w = random_vector(random, 1.0);
      system.A.block(system.A.diagonal(i)) += scale * (u * u.transpose());
      system.A.block(system.A.diagonal(j)) += scale * (w * w.transpose());
      system.A.block(system.A.find(i, j)) += scale * (u * w.transpose());
      system.A.block(system.A.find(j, i)) += scale * (w * u.transpose());
    }
  }
  system.dense = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (int i = 0; i < n; ++i) {
    for (int at = system.A.row_begin(i); at < system.A.row_end(i); ++at) {
      system.dense.block<3, 3>(3 * i, 3 * system.A.column(at)) = system.A.block(at);
    }
  }
  return system;
}

}  // namespace kerf::fem
