#include "server/fem/material_table.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "server/base/check.h"
#include "server/fem/mass_redistribution.h"

namespace kerf::fem {
namespace {

Eigen::Matrix2d rotation_into_material_axes(double direction) {
  const double c = std::cos(direction);
  const double s = std::sin(direction);
  return Eigen::Matrix2d{
      {c, s},
      {-s, c},
  };
}

}  // namespace

MaterialLaw::MaterialLaw(const Material& of)
    : material(of),
      membrane(membrane_law(of)),
      bending(bending_law(of)),
      inverse_bending(has_bending() ? Eigen::Matrix3d(bending.inverse()) : Eigen::Matrix3d::Zero()),
      axes(rotation_into_material_axes(of.direction)),
      surface_density(of.density * of.thickness) {
  // Mass, for edges of 1 m, and stiffness of an inner vertex of a uniform grid: six triangles of half a square each.
  const double typical_stiffness = 2.0 * (membrane(0, 0) + membrane(1, 1) + 2.0 * membrane(2, 2));
  unit_floor = kMassFloor * surface_density / typical_stiffness;
}

MaterialTable::MaterialTable(std::span<const Material> materials) {
  KERF_CHECK(!materials.empty() && materials.size() <= kMaxMaterials, "a sheet has 1..kMaxMaterials materials");
  for (const Material& material : materials) {
    laws_.emplace_back(material);
    stiffness_damping_.push_back(material.stiffness_damping);
    largest_membrane_trace_ = std::max(largest_membrane_trace_, laws_.back().membrane.trace());
    has_bending_ = has_bending_ || laws_.back().has_bending();
    has_one_mass_damping_ = has_one_mass_damping_ && material.mass_damping == materials.front().mass_damping;
  }
}

}  // namespace kerf::fem
