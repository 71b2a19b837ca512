#include "server/core/fem/element/material_table.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "server/base/check.h"
#include "server/base/elementary.h"
#include "server/core/fem/element/membrane_curvature.h"

namespace kerf::fem {
namespace {

Eigen::Matrix2d rotation_into_material_axes(double direction) {
  const double c = cosine(direction);
  const double s = sine(direction);
  return Eigen::Matrix2d{
      {c, s},
      {-s, c},
  };
}

// Returns the least stiffness over directions n. It is a parabola in p, the squared cosine of the angle of n, with p in
// 0..1.
double least_stiffness(const Eigen::Matrix3d& C) {
  const double mixed = C(0, 1) + 2.0 * C(2, 2);
  const double curvature = C(0, 0) + C(1, 1) - 2.0 * mixed;
  const double p = curvature > 0.0 ? std::clamp((C(1, 1) - mixed) / curvature, 0.0, 1.0) : 0.0;
  const double inside = C(0, 0) * p * p + C(1, 1) * (1.0 - p) * (1.0 - p) + 2.0 * mixed * p * (1.0 - p);
  return std::min({inside, C(0, 0), C(1, 1)});
}

}  // namespace

MaterialLaw::MaterialLaw(const Material& of)
    : material(of),
      membrane(membrane_law(of)),
      bending(bending_law(of)),
      inverse_bending(has_bending() ? Eigen::Matrix3d(bending.inverse()) : Eigen::Matrix3d::Zero()),
      axes(rotation_into_material_axes(of.direction)),
      least_membrane(least_stiffness(membrane)),
      curvature_bound(membrane_curvature_bound(membrane)),
      surface_density(of.density * of.thickness) {
  // Mass and stiffness of an inner vertex of a uniform grid with edges of 1 m: six triangles, each half a square.
  const double typical_stiffness = 2.0 * (membrane(0, 0) + membrane(1, 1) + 2.0 * membrane(2, 2));
  unit_floor = kMassFloor * surface_density / typical_stiffness;
}

MaterialTable::MaterialTable(std::span<const Material> materials, MembraneLaw law) : membrane_law_(law) {
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
