#include "server/fem/material.h"

#include <array>
#include <cstdio>
#include <string>

namespace kerf::fem {
namespace {

struct Field {
  std::string_view name;
  double Material::*member;
  Range range;
};

constexpr std::array<Field, 10> kFields{{
    {"youngs_modulus_1_pa", &Material::youngs_modulus_1, MaterialRanges::kYoungsModulus},
    {"youngs_modulus_2_pa", &Material::youngs_modulus_2, MaterialRanges::kYoungsModulus},
    {"shear_modulus_pa", &Material::shear_modulus, MaterialRanges::kShearModulus},
    {"poissons_ratio_12", &Material::poissons_ratio_12, MaterialRanges::kPoissonsRatio12},
    {"direction_rad", &Material::direction, MaterialRanges::kDirection},
    {"thickness_m", &Material::thickness, MaterialRanges::kThickness},
    {"density_kg_m3", &Material::density, MaterialRanges::kDensity},
    {"bending_scale", &Material::bending_scale, MaterialRanges::kBendingScale},
    {"mass_damping_per_s", &Material::mass_damping, MaterialRanges::kMassDamping},
    {"stiffness_damping_s", &Material::stiffness_damping, MaterialRanges::kStiffnessDamping},
}};

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

// nu12 nu21 = nu12^2 E2 / E1: must stay below 1 for C to be positive definite.
double poisson_product(const Material& m) {
  return m.poissons_ratio_12 * m.poissons_ratio_12 * m.youngs_modulus_2 / m.youngs_modulus_1;
}

}  // namespace

Material isotropic(double youngs_modulus, double poissons_ratio, double thickness, double density) {
  Material m;
  m.youngs_modulus_1 = youngs_modulus;
  m.youngs_modulus_2 = youngs_modulus;
  m.poissons_ratio_12 = poissons_ratio;
  m.shear_modulus = youngs_modulus / (2.0 * (1.0 + poissons_ratio));
  m.thickness = thickness;
  m.density = density;
  return m;
}

Status validate(const Material& material, std::string_view prefix) {
  const auto path = [prefix](std::string_view field) { return std::string(prefix) + "." + std::string(field); };
  for (const auto& [name, member, range] : kFields) {
    const double value = material.*member;
    if (value >= range.low && value <= range.high) continue;  // false for NaN
    return invalid_argument("MATERIAL_OUT_OF_RANGE",
                            path(name) + " is " + number(value) + "; choose a value in [" + number(range.low) + ", " +
                                number(range.high) + "]",
                            path(name));
  }
  const double product = poisson_product(material);
  if (!(product < 1.0)) {
    return invalid_argument("MATERIAL_NOT_POSITIVE_DEFINITE",
                            path("poissons_ratio_12") + ": poissons_ratio_12^2 E2 / E1 is " + number(product) +
                                "; choose values that make it less than 1",
                            path("poissons_ratio_12"));
  }
  return Nothing{};
}

Eigen::Matrix3d membrane_law(const Material& m) {
  const double nu12 = m.poissons_ratio_12;
  const double t = m.thickness;
  const double scale = t / (1.0 - poisson_product(m));
  const double C11 = scale * m.youngs_modulus_1;
  const double C22 = scale * m.youngs_modulus_2;
  const double C12 = nu12 * C22;
  return Eigen::Matrix3d{
      {C11, C12, 0.0},
      {C12, C22, 0.0},
      {0.0, 0.0, t * m.shear_modulus},
  };
}

Eigen::Matrix3d bending_law(const Material& m) {
  return (m.bending_scale * m.thickness * m.thickness / 12.0) * membrane_law(m);
}

}  // namespace kerf::fem
