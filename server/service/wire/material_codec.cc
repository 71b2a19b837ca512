#include "server/service/wire/material_codec.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "server/service/wire/choices.h"

namespace kerf::wire {
namespace {

// Describes an optional number of the message and its interval.
struct Field {
  const char* name;
  bool (v1::Material::*has)() const;
  double (v1::Material::*get)() const;
  fem::Range range;
  bool open = false;  // The interval is open.
};

using Ranges = fem::MaterialRanges;
constexpr Field kFields[] = {
    {"youngs_modulus_pa", &v1::Material::has_youngs_modulus_pa, &v1::Material::youngs_modulus_pa,
     Ranges::kYoungsModulus},
    {"youngs_modulus_2_pa", &v1::Material::has_youngs_modulus_2_pa, &v1::Material::youngs_modulus_2_pa,
     Ranges::kYoungsModulus},
    // Narrower than fem's, because G = E / (2 (1 + nu)) must be finite and positive.
    {"poissons_ratio", &v1::Material::has_poissons_ratio, &v1::Material::poissons_ratio, {-1.0, 1.0}, true},
    {"shear_modulus_pa", &v1::Material::has_shear_modulus_pa, &v1::Material::shear_modulus_pa, Ranges::kShearModulus},
    {"direction_rad", &v1::Material::has_direction_rad, &v1::Material::direction_rad, Ranges::kDirection},
    {"thickness_m", &v1::Material::has_thickness_m, &v1::Material::thickness_m, Ranges::kThickness},
    {"density_kgpm3", &v1::Material::has_density_kgpm3, &v1::Material::density_kgpm3, Ranges::kDensity},
    {"bending_scale", &v1::Material::has_bending_scale, &v1::Material::bending_scale, Ranges::kBendingScale},
    {"mass_damping_per_s", &v1::Material::has_mass_damping_per_s, &v1::Material::mass_damping_per_s,
     Ranges::kMassDamping},
    {"stiffness_damping_s", &v1::Material::has_stiffness_damping_s, &v1::Material::stiffness_damping_s,
     Ranges::kStiffnessDamping},
    {"strain_limit", &v1::Material::has_strain_limit, &v1::Material::strain_limit, Ranges::kStrainLimit},
    {"bending_stiffness_1_nm", &v1::Material::has_bending_stiffness_1_nm, &v1::Material::bending_stiffness_1_nm,
     Ranges::kBendingStiffness},
    {"bending_stiffness_2_nm", &v1::Material::has_bending_stiffness_2_nm, &v1::Material::bending_stiffness_2_nm,
     Ranges::kBendingStiffness},
    {"bending_coupling_nm", &v1::Material::has_bending_coupling_nm, &v1::Material::bending_coupling_nm,
     Ranges::kBendingCoupling},
    {"twisting_stiffness_nm", &v1::Material::has_twisting_stiffness_nm, &v1::Material::twisting_stiffness_nm,
     Ranges::kBendingStiffness},
};

constexpr std::array<std::pair<v1::MembraneLaw, fem::MembraneLaw>, 2> kMembraneLaws{{
    {v1::COROTATIONAL, fem::MembraneLaw::kCorotational},
    {v1::GREEN, fem::MembraneLaw::kGreen},
}};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", value);
  return text;
}

Status check(const Field& field, const v1::Material& material, const std::string& prefix) {
  if (!(material.*field.has)()) return Nothing{};
  const double value = (material.*field.get)();
  const std::string path = prefix + "." + field.name;
  if (!std::isfinite(value)) return invalid_argument("NOT_FINITE", path + " must be a finite number", path);
  const auto [low, high] = field.range;
  const bool inside = field.open ? value > low && value < high : value >= low && value <= high;
  if (inside) return Nothing{};
  return invalid_argument("OUT_OF_RANGE",
                          path + " is " + number(value) + "; choose a value " +
                              (field.open ? "strictly between " : "from ") + number(low) +
                              (field.open ? " and " : " to ") + number(high),
                          path);
}

void put_over(const v1::Material& given, fem::Material& material) {
  if (given.has_youngs_modulus_pa()) {
    material.youngs_modulus_1 = given.youngs_modulus_pa();
    material.youngs_modulus_2 = given.youngs_modulus_pa();
  }
  if (given.has_youngs_modulus_2_pa()) material.youngs_modulus_2 = given.youngs_modulus_2_pa();
  if (given.has_poissons_ratio()) material.poissons_ratio_12 = given.poissons_ratio();
  if (given.has_shear_modulus_pa()) {
    material.shear_modulus = given.shear_modulus_pa();
  } else if (given.has_youngs_modulus_pa()) {
    material.shear_modulus = given.youngs_modulus_pa() / (2.0 * (1.0 + material.poissons_ratio_12));
  }
  if (given.has_direction_rad()) material.direction = given.direction_rad();
  if (given.has_thickness_m()) material.thickness = given.thickness_m();
  if (given.has_density_kgpm3()) material.density = given.density_kgpm3();
  if (given.has_bending_scale()) material.bending_scale = given.bending_scale();
  if (given.has_mass_damping_per_s()) material.mass_damping = given.mass_damping_per_s();
  if (given.has_stiffness_damping_s()) material.stiffness_damping = given.stiffness_damping_s();
  if (given.has_strain_limit()) material.strain_limit = given.strain_limit();
  if (given.has_bending_stiffness_1_nm()) material.bending_stiffness_1 = given.bending_stiffness_1_nm();
  if (given.has_bending_stiffness_2_nm()) material.bending_stiffness_2 = given.bending_stiffness_2_nm();
  if (given.has_bending_coupling_nm()) material.bending_coupling = given.bending_coupling_nm();
  if (given.has_twisting_stiffness_nm()) material.twisting_stiffness = given.twisting_stiffness_nm();
}

}  // namespace

Result<fem::Material> decode_material(const v1::Material& given, const std::string& path) {
  const Result<fem::Material> preset = fem::find_preset(given.preset().empty() ? "demo" : given.preset());
  if (!preset.ok()) return invalid_argument("UNKNOWN_PRESET", preset.error().message, path + ".preset");
  for (const Field& field : kFields) {
    KERF_TRY(check(field, given, path));
  }
  fem::Material material = *preset;
  put_over(given, material);
  KERF_TRY(fem::validate(material, path));
  return material;
}

v1::Material encode_material(const fem::Material& material) {
  v1::Material message;
  message.set_youngs_modulus_pa(material.youngs_modulus_1);
  message.set_youngs_modulus_2_pa(material.youngs_modulus_2);
  message.set_poissons_ratio(material.poissons_ratio_12);
  message.set_shear_modulus_pa(material.shear_modulus);
  message.set_direction_rad(material.direction);
  message.set_thickness_m(material.thickness);
  message.set_density_kgpm3(material.density);
  message.set_bending_scale(material.bending_scale);
  message.set_mass_damping_per_s(material.mass_damping);
  message.set_stiffness_damping_s(material.stiffness_damping);
  message.set_strain_limit(material.strain_limit);
  if (material.bending_stiffness_1) message.set_bending_stiffness_1_nm(*material.bending_stiffness_1);
  if (material.bending_stiffness_2) message.set_bending_stiffness_2_nm(*material.bending_stiffness_2);
  if (material.bending_coupling) message.set_bending_coupling_nm(*material.bending_coupling);
  if (material.twisting_stiffness) message.set_twisting_stiffness_nm(*material.twisting_stiffness);
  return message;
}

Status decode_membrane_law(v1::MembraneLaw message, fem::MembraneLaw& law) {
  return decode_choice(kMembraneLaws, message, "membrane_law", law);
}

v1::MembraneLaw encode_membrane_law(fem::MembraneLaw law) {
  return encode_choice(kMembraneLaws, law);
}

}  // namespace kerf::wire
