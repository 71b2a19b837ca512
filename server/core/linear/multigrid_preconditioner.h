#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/linear/preconditioner.h"
#include "server/core/linear/supernodal_cholesky.h"
#include "server/core/linear/vertex_aggregates.h"

namespace kerf::linear {

// Two levels of multigrid by aggregation (Vanek, Mandel, Brezina 1996, with their tentative interpolation). A cycle is
// a forward sweep of Gauss-Seidel by vertices, a coarse correction, and a backward sweep. The coarse correction solves
// for the motion of aggregates as rigid bodies with a Cholesky factor. Memory and work, except that of the factor, are
// in proportion to the number of vertices. Cycles use single precision and frames that turn with the sheet; see
// FactorPreconditioner.
//
// If positions() are never set the bodies do not rotate, and a stiff sheet takes ten times the iterations.
class MultigridPreconditioner final : public Preconditioner {
 public:
  void analyse(const BlockMatrix& A) override;
  bool prepare(const BlockMatrix& A) override;
  void apply(const VertexField& r, VertexField& z) override;
  void set_stop_condition(const StopCondition* stop) override { factor_.set_stop_condition(stop); }
  std::vector<Eigen::Matrix3d>* frames() override { return &frames_; }
  VertexField* positions() override { return &positions_; }

 private:
  static constexpr int kModes = 6;  // degrees of freedom of a rigid body
  // Matrices of three rows and a row of zeros, so that a column fills one vector register.
  using Column4f = Eigen::Vector4f;
  using Block4f = Eigen::Matrix<float, 4, 3>;
  using Modes = Eigen::Matrix<double, 3, kModes>;
  using Modes4f = Eigen::Matrix<float, 4, kModes>;
  using Body = Eigen::Matrix<float, kModes, 1>;

  // Block of row i of L P in the columns of one aggregate. L is the part of A strictly below the diagonal, and P
  // interpolates from bodies to vertices.
  struct Link {
    int aggregate = 0;
    int row = 0;     // offset of block (aggregate of i, `aggregate`) from the beginning of its row of the coarse matrix
    int column = 0;  // offset of the transposed block in the same way
  };

  void set_lower_pattern(const BlockMatrix& A);
  void set_coarse_pattern(const BlockMatrix& A);
  [[nodiscard]] int coarse_place(int row, int column) const;
  void find_modes(const BlockMatrix& A);
  bool load_rows(const BlockMatrix& A);
  // Adds X to a block of the coarse matrix. `row` is the aggregate of its rows; `place` is an offset as in Link.
  void add_to_coarse(int row, int place, const Eigen::Matrix<double, kModes, kModes>& X);
  void sweep_forward();
  void correct_bodies();
  void sweep_backward();

  std::vector<Eigen::Matrix3d> frames_;  // N
  VertexField positions_;                // 3 x N, m
  VertexAggregates aggregates_;

  std::vector<int> lower_begin_;  // N + 1, beginnings of rows in lower_column_ and lower_
  std::vector<int> lower_column_;
  std::vector<Block4f> lower_;    // L
  std::vector<int> upper_begin_;  // N + 1, beginnings of rows in upper_column_ and upper_
  std::vector<int> upper_column_;
  std::vector<Block4f> upper_;    // L^T
  std::vector<Block4f> inverse_;  // N, inverses of diagonal blocks
  std::vector<Modes> modes_;      // N, rows of P: motion of a vertex with its aggregate; 0 in components that row i
                                  // couples with no other vertex
  std::vector<int> link_begin_;   // N + 1, beginnings of rows in links_ and linked_
  std::vector<Link> links_;
  std::vector<Modes4f> linked_;  // L P

  BlockMatrix coarse_;  // P^T A P; two rows of 3x3 blocks a body
  SupernodalCholesky<float> factor_;
  std::vector<Modes> row_;         // scratch: a row of L P
  std::vector<int> link_of_;       // scratch: link of an aggregate in the current row
  std::vector<Column4f> z_, sum_;  // N; sum_: r - L z
  std::vector<Body> body_;         // residual, then correction, of each aggregate
  VertexField coarse_b_;           // 3 x twice the aggregates
};

}  // namespace kerf::linear
