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

// Bending that sees angles and nothing of what the sheet does in its own plane. The energy of bending.h and
// bending_edge.h is a quadratic form in the conditions w of the patches, vectors. Where a sheet bends without
// stretching, w_r is the height of the vertex across edge r times the angle theta of the hinge there (see hinge.h),
// along the normal and to the square of the angle; where it is strained in its plane, w has parts in the plane too,
// which no plate resists: too stiff by (thickness / distance over which strains change)^2. Here
//   E = 1/2 sum over patches of theta.L theta + sum over inner edges of (kink.theta) (load.theta)
// with L_rs = law_rs reach_r reach_s, and the kinks and loads likewise. A clamped edge is a hinge to the plane that is
// held. Invariant under all rigid motions, never negative, 0 in the plane; not quadratic any more.
class AngleBending {
 public:
  struct Fold {
    // As of Hinge; the last one kNone at a clamped edge, where it is the middle of the edge and `held` from there.
    std::array<mesh::VertexId, 4> vertex{mesh::kNone, mesh::kNone, mesh::kNone, mesh::kNone};
    Eigen::Vector3d held = Eigen::Vector3d::Zero();  // m
    HingeSize rest;
  };
  struct Patch {
    std::array<int, 3> fold{-1, -1, -1};                  // -1: none
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  // J
  };
  struct Kink {
    std::array<int, 5> fold{-1, -1, -1, -1, -1};
    std::array<double, 5> kink{};  // -
    std::array<double, 5> load{};  // J
    // To the entries of fold `at`; nothing where it is -1.
    void add(int at, double to_kink, double to_load);
  };

  std::vector<Fold> folds;
  std::vector<Patch> patches;
  std::vector<Kink> kinks;

  // x: 3 x V, m.
  [[nodiscard]] double energy(const mesh::VertexField& x) const;  // J
  // f (3 x V, N) += minus the gradient of the energy.
  void add_forces(const mesh::VertexField& x, mesh::VertexField& f) const;
  // J, derivatives of the energy by the angles of the folds as a step from x (3 x V, m) would change them to first
  // order.
  [[nodiscard]] std::vector<double> predicted_moments(const mesh::VertexField& x, const mesh::VertexField& step) const;
  // Adds the second derivatives of the energy at x, N/m, with `moments` (J, one a fold) in place of those at x, or
  // none; with `project` without those of the angles (Gauss-Newton), which leaves it positive semidefinite. The matrix
  // must have the blocks of all pairs of vertices of a patch and of the two patches at a kink.
  void add_stiffness(const mesh::VertexField& x, std::span<const double> moments, bool project,
                     BlockMatrix& matrix) const;

 private:
  [[nodiscard]] std::vector<double> moments_at(const std::vector<double>& theta) const;  // J, of the energy by theta
};

}  // namespace kerf::fem
