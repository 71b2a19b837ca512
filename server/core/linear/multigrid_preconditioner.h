#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/linear/preconditioner.h"
#include "server/core/linear/supernodal_cholesky.h"
#include "server/core/linear/vertex_aggregates.h"

namespace kerf::fem {

// Two levels of multigrid by aggregation (Vanek, Mandel, Brezina 1996, with their tentative interpolation): a sweep of
// Gauss-Seidel forward by vertices, the motion of aggregates as rigid bodies solved for with a Cholesky factor, and a
// sweep backward. Memory and, but for that factor, work grow with the vertices. All of it in single precision and in
// frames that turn with the sheet; see FactorPreconditioner.
//
// Without positions bodies do not rotate, and a stiff sheet takes ten times the iterations.
class MultigridPreconditioner final : public Preconditioner {
 public:
  void analyse(const BlockMatrix& A) override;
  bool prepare(const BlockMatrix& A) override;
  void apply(const mesh::VertexField& r, mesh::VertexField& z) override;
  void heed(const GoesOn* goes_on) override { factor_.heed(goes_on); }
  std::vector<Eigen::Matrix3d>* frames() override { return &frames_; }
  mesh::VertexField* positions() override { return &positions_; }

 private:
  static constexpr int kModes = 6;  // of a rigid body
  // Three rows and one of zeros: so that a column is one vector register.
  using Column4f = Eigen::Vector4f;
  using Block4f = Eigen::Matrix<float, 4, 3>;
  using Modes = Eigen::Matrix<double, 3, kModes>;
  using Modes4f = Eigen::Matrix<float, 4, kModes>;
  using Body = Eigen::Matrix<float, kModes, 1>;

  // What row i of L P, L being A strictly below the diagonal and P the interpolation, has in the columns of an
  // aggregate.
  struct Link {
    int aggregate = 0;
    int row = 0;     // place of block (own aggregate, this one) of the coarse matrix from the beginning of its row
    int column = 0;  // that of its transpose
  };

  void set_lower_pattern(const BlockMatrix& A);
  void set_coarse_pattern(const BlockMatrix& A);
  [[nodiscard]] int coarse_place(int row, int column) const;
  void find_modes(const BlockMatrix& A);
  bool load_rows(const BlockMatrix& A);
  // Adds X, kModes x kModes, to a block of bodies of the coarse matrix.
  void add_to_coarse(int row, int place, const Eigen::Matrix<double, kModes, kModes>& X);
  void sweep_forward();
  void correct_bodies();
  void sweep_backward();

  std::vector<Eigen::Matrix3d> frames_;  // N
  mesh::VertexField positions_;          // 3 x N, m
  VertexAggregates aggregates_;

  std::vector<int> lower_begin_;  // N + 1, of rows in what follows
  std::vector<int> lower_column_;
  std::vector<Block4f> lower_;    // L
  std::vector<int> upper_begin_;  // N + 1, of rows in what follows
  std::vector<int> upper_column_;
  std::vector<Block4f> upper_;    // L^T
  std::vector<Block4f> inverse_;  // N, of diagonal blocks
  std::vector<Modes> modes_;      // N, P: how a vertex moves with its aggregate; 0 where pins hold
  std::vector<int> link_begin_;   // N + 1, of rows in what follows
  std::vector<Link> links_;
  std::vector<Modes4f> linked_;  // L P

  BlockMatrix coarse_;  // P^T A P; two rows of 3x3 blocks a body
  SupernodalCholesky<float> factor_;
  std::vector<Modes> row_;         // scratch: a row of L P
  std::vector<int> link_of_;       // scratch: of an aggregate in the row at hand
  std::vector<Column4f> z_, sum_;  // N; sum_: r - L z
  std::vector<Body> body_;         // residual and then correction of each aggregate
  mesh::VertexField coarse_b_;     // 3 x twice the aggregates
};

}  // namespace kerf::fem
