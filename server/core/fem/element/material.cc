#include "server/core/fem/element/material.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace kerf::fem {
namespace {

struct Field {
  std::string_view name;
  double Material::*member;
  Range range;
};

constexpr std::array<Field, 11> kFields{{
    {"youngs_modulus_pa", &Material::youngs_modulus_1, MaterialRanges::kYoungsModulus},
    {"youngs_modulus_2_pa", &Material::youngs_modulus_2, MaterialRanges::kYoungsModulus},
    {"shear_modulus_pa", &Material::shear_modulus, MaterialRanges::kShearModulus},
    {"poissons_ratio", &Material::poissons_ratio_12, MaterialRanges::kPoissonsRatio12},
    {"direction_rad", &Material::direction, MaterialRanges::kDirection},
    {"thickness_m", &Material::thickness, MaterialRanges::kThickness},
    {"density_kgpm3", &Material::density, MaterialRanges::kDensity},
    {"bending_scale", &Material::bending_scale, MaterialRanges::kBendingScale},
    {"mass_damping_per_s", &Material::mass_damping, MaterialRanges::kMassDamping},
    {"stiffness_damping_s", &Material::stiffness_damping, MaterialRanges::kStiffnessDamping},
    {"strain_limit", &Material::strain_limit, MaterialRanges::kStrainLimit},
}};

struct OptionalField {
  std::string_view name;
  std::optional<double> Material::*member;
  Range range;
};

constexpr std::array<OptionalField, 4> kBendingFields{{
    {"bending_stiffness_1_nm", &Material::bending_stiffness_1, MaterialRanges::kBendingStiffness},
    {"bending_stiffness_2_nm", &Material::bending_stiffness_2, MaterialRanges::kBendingStiffness},
    {"bending_coupling_nm", &Material::bending_coupling, MaterialRanges::kBendingCoupling},
    {"twisting_stiffness_nm", &Material::twisting_stiffness, MaterialRanges::kBendingStiffness},
}};

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

// Returns nu12 nu21 = nu12^2 E2 / E1, which must be below 1 for C to be positive definite.
double poisson_product(const Material& m) {
  return m.poissons_ratio_12 * m.poissons_ratio_12 * m.youngs_modulus_2 / m.youngs_modulus_1;
}

Status check_range(double value, const Range& range, const std::string& path) {
  if (value >= range.low && value <= range.high) return Nothing{};  // false for NaN
  return invalid_argument(
      "MATERIAL_OUT_OF_RANGE",
      path + " is " + number(value) + "; choose a value in [" + number(range.low) + ", " + number(range.high) + "]",
      path);
}

// Rejects bending stiffnesses that are given only in part, or that are inconsistent.
Status check_bending(const Material& m, const std::string& prefix) {
  bool has_given = false;
  const OptionalField* absent = nullptr;  // the last absent one of the stiffnesses that must not be 0
  for (const OptionalField& field : kBendingFields) {
    const std::optional<double>& value = m.*field.member;
    if (!value && field.member != &Material::bending_coupling) absent = &field;
    if (!value) continue;
    has_given = true;
    KERF_TRY(check_range(*value, field.range, prefix + "." + std::string(field.name)));
  }
  if (!has_given) return Nothing{};
  if (absent != nullptr && m.bending_scale == 0.0) {
    const std::string path = prefix + "." + std::string(absent->name);
    return invalid_argument("MATERIAL_NOT_POSITIVE_DEFINITE",
                            path +
                                " is not given, and a bending_scale of 0 makes it 0; give it too, or a bending_scale "
                                "above 0, or no bending stiffness at all",
                            path);
  }
  const Eigen::Matrix3d D = bending_law(m);
  const double limit = std::sqrt(D(0, 0) * D(1, 1));
  if (std::abs(D(0, 1)) < limit) return Nothing{};
  const std::string path = prefix + ".bending_coupling_nm";
  return invalid_argument("MATERIAL_NOT_POSITIVE_DEFINITE",
                          path + " is " + number(D(0, 1)) + (m.bending_coupling ? "" : ", derived") +
                              "; with stiffnesses of " + number(D(0, 0)) + " and " + number(D(1, 1)) +
                              " N m, give a value between -" + number(limit) + " and " + number(limit),
                          path);
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
    KERF_TRY(check_range(material.*member, range, path(name)));
  }
  const double product = poisson_product(material);
  if (!(product < 1.0)) {
    return invalid_argument("MATERIAL_NOT_POSITIVE_DEFINITE",
                            path("poissons_ratio") + "^2 youngs_modulus_2_pa / youngs_modulus_pa is " +
                                number(product) + "; choose values that make it less than 1",
                            path("poissons_ratio"));
  }
  return check_bending(material, std::string(prefix));
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
  Eigen::Matrix3d D = (m.bending_scale * m.thickness * m.thickness / 12.0) * membrane_law(m);
  if (m.bending_stiffness_1) D(0, 0) = *m.bending_stiffness_1;
  if (m.bending_stiffness_2) D(1, 1) = *m.bending_stiffness_2;
  if (m.bending_coupling) D(0, 1) = D(1, 0) = *m.bending_coupling;
  if (m.twisting_stiffness) D(2, 2) = *m.twisting_stiffness;
  return D;
}

Material without_bending(Material material) {
  material.bending_scale = 0.0;
  for (const OptionalField& field : kBendingFields) (material.*field.member).reset();
  return material;
}

}  // namespace kerf::fem
