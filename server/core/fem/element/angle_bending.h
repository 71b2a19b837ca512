#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/hinge.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::linear {
class BlockMatrix;
}  // namespace kerf::linear

namespace kerf::fem {

// Bending energy that depends on angles only and ignores in-plane motion. The energy of bending.h and bending_edge.h is
// a quadratic form in the conditions w of the patches, which are vectors. Where a sheet bends without stretching, w_r
// is along the normal to second order in the angle. Its size is the height of the vertex across edge r times the hinge
// angle theta there (see hinge.h). Where a sheet is strained in its plane, w has in-plane parts as well, which no plate
// resists. They make it too stiff by (thickness / distance over which strains change)^2. Here
//   E = 1/2 sum over patches of theta.L theta + sum over inner edges of (kink.theta) (load.theta)
// with L_rs = law_rs reach_r reach_s. The law is that of BendingFit, and reach_r is the height of the vertex across
// edge r. Kinks and loads are made from those of BendingEdge with the same heights. A clamped edge is a hinge to the
// held plane. The energy is invariant under all rigid motions, never negative, and 0 in the plane. It is not quadratic
// in the positions.
class AngleBending {
 public:
  struct Fold {
    // The four points of the Hinge, in its order. At a clamped edge the last one is kNone, and the hinge uses the
    // middle of the edge plus `held` in its place.
    std::array<mesh::VertexId, 4> vertex{mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone};
    Eigen::Vector3d held = Eigen::Vector3d::Zero();  // m, at a clamped edge: from its middle to the held point
    HingeSize rest;
  };
  struct Patch {
    std::array<int, 3> fold{-1, -1, -1};                  // index in `folds` of the fold at each edge; -1 if the edge
                                                          // has none
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  // J
  };
  // Term of one edge between two patches: (sum_i kink_i theta_i) (sum_i load_i theta_i), over the folds of both
  // patches.
  struct Kink {
    std::array<int, 5> fold{-1, -1, -1, -1, -1};
    std::array<double, 5> kink{};  // -
    std::array<double, 5> load{};  // J
    // Adds to the coefficients of fold `at`, an index in `folds`. Does nothing if it is -1.
    void add(int at, double to_kink, double to_load);
  };

  std::vector<Fold> folds;
  std::vector<Patch> patches;
  std::vector<Kink> kinks;

  // Returns the energy at x (3 x V, m).
  [[nodiscard]] double energy(const linear::VertexField& x) const;  // J
  // Adds minus the gradient of the energy to f (3 x V, N).
  void add_forces(const linear::VertexField& x, linear::VertexField& f) const;
  // Returns the derivatives of the energy by the fold angles after `step` from x (both 3 x V, m), in J. The angles are
  // predicted to first order.
  [[nodiscard]] std::vector<double> predicted_moments(const linear::VertexField& x,
                                                      const linear::VertexField& step) const;
  // Adds the second derivatives of the energy at x, N/m. Non-empty `moments` (J, one a fold) replace the derivatives of
  // the energy by the angles at x. `project` leaves out the second derivatives of the angles (Gauss-Newton), which
  // makes the matrix positive semidefinite. The matrix must have the blocks of all pairs of vertices of a patch and of
  // the two patches at a kink.
  void add_stiffness(const linear::VertexField& x, std::span<const double> moments, bool project,
                     linear::BlockMatrix& matrix) const;

 private:
  [[nodiscard]] std::vector<double> moments_at(const std::vector<double>& theta) const;  // J, derivatives of the energy
                                                                                         // by theta
};

}  // namespace kerf::fem
