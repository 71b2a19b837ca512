#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_edge.h"
#include "server/core/linear/lanes16.h"

namespace kerf::fem {

// The fits of kBlockLanes patches, see bending.h and bending_edge.h, in vector code chosen for the processor at run
// time. Lanes never mix and no multiply-add is fused. Results have the same bits on every processor, whatever the other
// lanes hold. Symmetric matrices are upper triangles by rows.
struct PatchLanes {
  using Value = Lanes16<double>;
  using Vector2 = std::array<Value, 2>;
  using Vector3 = std::array<Value, 3>;
  using Symmetric3 = std::array<Value, 6>;

  // Sets a lane. D is the plate law, N m, used only for the penalty of the sides.
  void set(std::size_t lane, const PatchGeometry& patch, const Eigen::Matrix3d& D, const Eigen::Matrix3d& D_inverse);
  // Fits the lanes below `count`, which must be set.
  void fit(std::size_t count);

  [[nodiscard]] BendingFit fit_of(std::size_t lane) const;
  [[nodiscard]] std::array<double, 21> stiffness_of(std::size_t lane) const;  // as in BendingPatch
  // Returns the data of the patch at the edge opposite corner `edge`.
  [[nodiscard]] BendingSide side_of(std::size_t lane, std::size_t edge) const;

  // Input.
  std::array<Vector2, 2> edges{};   // m; corners 1 and 2 about corner 0
  std::array<Vector2, 3> across{};  // m; the opposite vertices about corner 0, or clamp_arm
  Vector3 kind{};                   // PatchEdge, as a number
  Symmetric3 D{};                   // N m
  Symmetric3 D_inverse{};           // 1/(N m)

  // Intermediate results between the two halves of the fit.
  std::array<Vector3, 3> lambda{};  // -; 0 for a missing condition
  Vector3 over_size{};              // reciprocal size of each condition
  std::array<Vector3, 3> terms{};   // m^2; for conditions of unit size
  Symmetric3 gram{}, G{}, inverse{};
  Value is_regular{};  // 1 if `inverse` is the true inverse, 0 if it must be replaced by the pseudo-inverse

  // Output; see BendingFit and BendingSide.
  Symmetric3 law{};
  std::array<Value, 21> stiffness{};
  struct Side {
    std::array<Value, 6> slope{}, moment{};
    Value length{}, penalty{};
  };
  std::array<Side, 3> sides{};
};

}  // namespace kerf::fem
