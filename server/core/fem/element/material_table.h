#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/material.h"

namespace kerf::fem {

inline constexpr std::size_t kMaxMaterials = 16;  // per sheet

// Target (-) of mass_redistribution.h. Every vertex should have at least this part of the mass over stiffness of a
// regular inner vertex. That is a vertex in a uniform grid with the edge length that the sheet as built has there.
inline constexpr double kMassFloor = 0.25;

// Constants of a material used by elements.
struct MaterialLaw {
  explicit MaterialLaw(const Material& of);

  Material material;
  Eigen::Matrix3d membrane;         // N/m, in material axes, Voigt (e11, e22, 2 e12)
  Eigen::Matrix3d bending;          // N m, in material axes, Voigt (k11, k22, 2 k12); 0 without bending
  Eigen::Matrix3d inverse_bending;  // 1/(N m); 0 without bending
  Eigen::Matrix2d axes;             // rotation of rest coordinates into material axes
  double least_membrane = 0.0;      // N/m, stiffness n n : C : n n of the softest direction n in the plane
  double curvature_bound = 0.0;     // N/m, z of membrane_curvature.h
  double surface_density = 0.0;     // kg/m^2
  double unit_floor = 0.0;          // kg/m^2 / (N/m); least mass wanted for a vertex over its stiffness, for edges of 1
                                    // m

  [[nodiscard]] bool has_bending() const { return bending(0, 0) > 0.0; }
};

// The materials of a sheet, 1..kMaxMaterials, by ElementBlock::material.
class MaterialTable {
 public:
  // All materials must be valid (see validate).
  explicit MaterialTable(std::span<const Material> materials, MembraneLaw law = MembraneLaw::kCorotational);

  [[nodiscard]] MembraneLaw membrane_law() const { return membrane_law_; }
  [[nodiscard]] std::size_t size() const { return laws_.size(); }
  [[nodiscard]] bool has_one() const { return laws_.size() == 1; }
  [[nodiscard]] const MaterialLaw& operator[](std::size_t material) const { return laws_[material]; }
  [[nodiscard]] const MaterialLaw& of(const ElementBlock& block, std::size_t lane) const {
    return laws_[block.material[lane]];
  }
  [[nodiscard]] auto begin() const { return laws_.begin(); }
  [[nodiscard]] auto end() const { return laws_.end(); }

  [[nodiscard]] bool has_bending() const { return has_bending_; }  // true if any material bends
  [[nodiscard]] bool has_one_mass_damping() const { return has_one_mass_damping_; }
  [[nodiscard]] double largest_membrane_trace() const { return largest_membrane_trace_; }  // N/m
  // Material::stiffness_damping of each material, s.
  [[nodiscard]] std::span<const double> stiffness_damping() const { return stiffness_damping_; }

 private:
  MembraneLaw membrane_law_;
  std::vector<MaterialLaw> laws_;
  std::vector<double> stiffness_damping_;
  double largest_membrane_trace_ = 0.0;
  bool has_bending_ = false;
  bool has_one_mass_damping_ = true;
};

// Returns the damping time of a material, s, >= 0; an empty `beta` means 0 everywhere.
inline double damping_of(std::span<const double> beta, std::size_t material) {
  return beta.empty() ? 0.0 : beta[material];
}
inline bool is_uniform(std::span<const double> beta) {
  for (const double each : beta) {
    if (each != beta.front()) return false;
  }
  return true;
}

}  // namespace kerf::fem
