#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_edge.h"
#include "server/core/linear/lanes16.h"

namespace kerf::fem {

// The fits of kBlockLanes patches, see bending.h and bending_edge.h, in vector code chosen for the processor at run
// time. Lanes never mix and nothing is contracted: the same bits on every processor, whatever is in the other lanes.
// Symmetric matrices are upper triangles by rows.
struct PatchLanes {
  using Value = Lanes16<double>;
  using Vector2 = std::array<Value, 2>;
  using Vector3 = std::array<Value, 3>;
  using Symmetric3 = std::array<Value, 6>;

  // D: plate law, N m, for the penalty of the sides alone.
  void set(std::size_t lane, const PatchGeometry& patch, const Eigen::Matrix3d& D, const Eigen::Matrix3d& D_inverse);
  // Of the lanes below `count`, once they are set.
  void fit(std::size_t count);

  [[nodiscard]] BendingFit fit_of(std::size_t lane) const;
  [[nodiscard]] std::array<double, 21> stiffness_of(std::size_t lane) const;  // as in BendingPatch
  // What the patch has at the edge opposite corner `edge`.
  [[nodiscard]] BendingSide side_of(std::size_t lane, std::size_t edge) const;

  // Input.
  std::array<Vector2, 2> edges{};   // m; corners 1 and 2 about corner 0
  std::array<Vector2, 3> across{};  // m; the opposite vertices about corner 0, or clamp_arm
  Vector3 kind{};                   // PatchEdge, as a number
  Symmetric3 D{};                   // N m
  Symmetric3 D_inverse{};           // 1/(N m)

  // Between the two halves of the fit.
  std::array<Vector3, 3> lambda{};  // -; 0 where there is no condition
  Vector3 over_size{};              // 1 over the size of each condition
  std::array<Vector3, 3> terms{};   // m^2; of conditions of unit size
  Symmetric3 gram{}, G{}, inverse{};
  Value is_regular{};  // 1 or 0: then the inverse is to be made again

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
