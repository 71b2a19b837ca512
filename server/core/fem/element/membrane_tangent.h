#pragma once

#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/element_lanes.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

using ElementMatrix = Eigen::Matrix<double, 9, 9>;  // rows and columns: corner * 3 + world axis
using ElementVector = Eigen::Matrix<double, 9, 1>;

// Second derivative of the energy of membrane.h for one triangle. The columns below are those of the in-plane
// displacement (u, v) of corner k in the frame R. (gx, gy) = g_k and w = (wu, wv):
//   spin      w = (-gy, gx) / tr S
//   strain    B = [gx + wu S12, wv S12; -wu S12, gy - wv S12; gy + wu (S22 - S11), gx + wv (S22 - S11)]
//   in plane  K_in = B^T C B + gamma w^T w + (w^T (c B) + (c B)^T w) / 2, gamma = sigma1 S11 + sigma2 S22 + 2 sigma3
//             S12,   c = (-2 T21, 2 T12, T11 - T22)
//   out       k_n = g_i^T Sigma g_j,   Sigma = S^-1 T (second Piola-Kirchhoff stress)
//   K_ij = A (R K_in R^T + k_n n n^T).
// The terms with gamma, c and Sigma are the geometric stiffness; B^T C B alone is positive semidefinite. For Green's
// strain, with F = R S and sigma = Sigma:
//   B = [S11 gx, S12 gx; S12 gy, S22 gy; S11 gy + S12 gx, S12 gy + S22 gx],
//   K_in = B^T C B + g_i^T Sigma g_j I,   k_n as above.
class MembraneTangent {
 public:
  // `frames` holds the frames of all lanes of the block.
  MembraneTangent(const ElementBlock& block, std::size_t lane, const LaneFrames& frames,
                  const MaterialTable& materials);

  // Returns sigma = C e, N/m, conjugate to the strain of the law.
  [[nodiscard]] Eigen::Vector3d stress() const { return C_ * e_; }
  // Returns C (e + B dx), the stress to first order after a displacement dx in world axes (m).
  [[nodiscard]] Eigen::Vector3d predicted_stress(const ElementVector& dx) const;

  // Sets K (N/m) to material_scale A B^T C B plus geometric_scale times the geometric stiffness for the stress sigma.
  // `project` changes the geometric part so that the whole is positive semidefinite for material_scale >=
  // geometric_scale. It replaces negative gamma and negative eigenvalues of Sigma by 0, and shortens c as far as
  // needed.
  void stiffness(const Eigen::Vector3d& sigma, double material_scale, double geometric_scale, bool project,
                 ElementMatrix& K) const;

 private:
  using Matrix36 = Eigen::Matrix<double, 3, 6>;
  using Matrix32 = Eigen::Matrix<double, 3, 2>;

  struct Geometric {
    double gamma = 0.0;
    Eigen::RowVector3d c = Eigen::RowVector3d::Zero();
    Eigen::Matrix2d Sigma = Eigen::Matrix2d::Zero();
  };
  void set_corotational();
  void set_green();
  [[nodiscard]] Geometric geometric(const Eigen::Vector3d& sigma, bool project) const;
  [[nodiscard]] Geometric corotational_part(const Eigen::Vector3d& sigma) const;

  MembraneLaw law_;
  double area_;
  const Eigen::Matrix3d& C_;
  Matrix32 R_;
  Eigen::Vector3d n_;
  Eigen::Matrix2d S_;
  Eigen::Vector3d e_;  // -, strain
  double inverse_trace_;
  Eigen::Matrix<double, 2, 3> g_;  // column k: gradient of corner k, 1/m
  Matrix36 B_;                     // columns: corner * 2 + frame axis
  Eigen::Matrix<double, 1, 6> w_;  // 0 with Green's strain
};

// Sets sigma of every lane, N/m, to the stress after a step (3 x V, m) from x (3 x V, m), to first order. Leaves lanes
// without material unchanged.
void predict_stress(std::span<const ElementBlock> blocks, const MaterialTable& materials, const linear::VertexField& x,
                    const linear::VertexField& step, std::span<Eigen::Vector3d> sigma);

}  // namespace kerf::fem
