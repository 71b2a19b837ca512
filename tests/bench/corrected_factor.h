#pragma once

#include <utility>
#include <vector>

#include "server/core/linear/block_matrix.h"
#include "server/core/linear/factor_preconditioner.h"
#include "server/core/linear/preconditioner.h"
#include "server/core/linear/supernodal_cholesky.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::bench {

// Corrects a factor from before a cut on a part S of the sheet that includes the new vertices. The block A_SS is
// factored again: symmetric multiplicative Schwarz, S - old - S. The old factor leaves new vertices at 0.
//
// The first S has nothing to do where the residual is 0 there. It is after start(), and stays so to rounding: each
// direction ends with S, which makes (A z)_S = r_S, and r_S = 0 then makes (A p)_S = 0. So old - S is the same
// preconditioner on all residuals that occur, for one solve of S and one product less.
class CorrectedFactor final : public linear::Preconditioner {
 public:
  // `before`: prepared, and its frames turned to now; of vertices [0, num_before). `part`: S, ascending; empty: the old
  // factor as it is.
  CorrectedFactor(linear::FactorPreconditioner& before, int num_before, std::vector<int> part)
      : before_(before), num_before_(num_before), part_(std::move(part)) {}

  void analyse(const linear::BlockMatrix& A) override;
  bool prepare(const linear::BlockMatrix& A) override;
  void apply(const linear::VertexField& r, linear::VertexField& z) override;

  // Changes x (3 x N) in S, so that b - A x is 0 there; after prepare().
  void start(const linear::VertexField& b, linear::VertexField& x);

 private:
  // x_S += A_SS^-1 (b - A x)_S.
  void correct(const linear::VertexField& b, linear::VertexField& x);

  linear::FactorPreconditioner& before_;
  int num_before_;
  std::vector<int> part_;
  std::vector<int> place_;  // of a vertex in S, or -1
  const linear::BlockMatrix* A_ = nullptr;
  linear::BlockMatrix A_SS_;
  linear::SupernodalCholesky<double> factor_;
  linear::VertexField old_r_, old_z_;  // 3 x num_before
  linear::VertexField of_part_;        // 3 x |S|
};

}  // namespace kerf::bench
