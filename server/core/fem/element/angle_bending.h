#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/hinge.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

class BlockMatrix;

// Bending energy that depends on angles only and ignores in-plane motion. The energy of bending.h and bending_edge.h is
// a quadratic form in the conditions w of the patches, which are vectors. Where a sheet bends without stretching, w_r
// is along the normal to second order in the angle. Its size is the height of the vertex across edge r times the hinge
// angle theta there (see hinge.h). Where a sheet is strained in its plane, w has in-plane parts as well, which no plate
// resists. They make it too stiff by (thickness / distance over which strains change)^2. Here
//   E = 1/2 sum over patches of theta.L theta + sum over inner edges of (kink.theta) (load.theta)
// with L_rs = law_rs reach_r reach_s, and the kinks and loads in the same way. A clamped edge is a hinge to the held
// plane. The energy is invariant under all rigid motions, never negative, and 0 in the plane. It is no longer
// quadratic.
class AngleBending {
 public:
  struct Fold {
    // As for Hinge. At a clamped edge the last one is kNone; the middle of the edge plus `held` takes its place.
    std::array<mesh::VertexId, 4> vertex{mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone};
    Eigen::Vector3d held = Eigen::Vector3d::Zero();  // m
    HingeSize rest;
  };
  struct Patch {
    std::array<int, 3> fold{-1, -1, -1};                  // -1 if there is none
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  // J
  };
  struct Kink {
    std::array<int, 5> fold{-1, -1, -1, -1, -1};
    std::array<double, 5> kink{};  // -
    std::array<double, 5> load{};  // J
    // Adds to the entries of fold `at`; does nothing if it is -1.
    void add(int at, double to_kink, double to_load);
  };

  std::vector<Fold> folds;
  std::vector<Patch> patches;
  std::vector<Kink> kinks;

  // Returns the energy at x (3 x V, m).
  [[nodiscard]] double energy(const mesh::VertexField& x) const;  // J
  // Adds minus the gradient of the energy to f (3 x V, N).
  void add_forces(const mesh::VertexField& x, mesh::VertexField& f) const;
  // Returns the derivatives of the energy by the fold angles, J, that a step from x (3 x V, m) would give to first
  // order.
  [[nodiscard]] std::vector<double> predicted_moments(const mesh::VertexField& x, const mesh::VertexField& step) const;
  // Adds the second derivatives of the energy at x, N/m. Non-empty `moments` (J, one a fold) replace those at x.
  // `project` leaves out the second derivatives of the angles (Gauss-Newton), which makes the matrix positive
  // semidefinite. The matrix must have the blocks of all pairs of vertices of a patch and of the two patches at a kink.
  void add_stiffness(const mesh::VertexField& x, std::span<const double> moments, bool project,
                     BlockMatrix& matrix) const;

 private:
  [[nodiscard]] std::vector<double> moments_at(const std::vector<double>& theta) const;  // J, by theta
};

}  // namespace kerf::fem
