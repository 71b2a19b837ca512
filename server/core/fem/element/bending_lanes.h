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
  using Value = linear::Lanes16<double>;
  using Vector2 = std::array<Value, 2>;
  using Vector3 = std::array<Value, 3>;
  using Symmetric3 = std::array<Value, 6>;

  // Sets the input of a lane. D is the plate law, N m, used only for BendingSide::penalty.
  void set(std::size_t lane, const PatchGeometry& patch, const Eigen::Matrix3d& D, const Eigen::Matrix3d& D_inverse);
  // Computes the output of the lanes below `count`, whose input must be set.
  void fit(std::size_t count);

  [[nodiscard]] BendingFit fit_of(std::size_t lane) const;
  [[nodiscard]] std::array<double, 21> stiffness_of(std::size_t lane) const;  // as in BendingPatch
  // Returns the side of the patch at the edge opposite corner `edge`.
  [[nodiscard]] BendingSide side_of(std::size_t lane, std::size_t edge) const;

  // Input.
  std::array<Vector2, 2> edges{};   // m; corners 1 and 2 about corner 0
  std::array<Vector2, 3> across{};  // m; the vertex across each edge about corner 0, or clamp_arm() if the edge is
                                    // clamped
  Vector3 kind{};                   // PatchEdge of each edge, as a number
  Symmetric3 D{};                   // N m
  Symmetric3 D_inverse{};           // 1/(N m)

  // Intermediate results between the two halves of the fit.
  std::array<Vector3, 3> lambda{};  // -; 0 for a missing condition
  Vector3 over_size{};              // reciprocal norms of the rows of C before they become unit rows; see
                                    // set_conditions()
  std::array<Vector3, 3> terms{};   // m^2; rows of -P, times over_size
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
