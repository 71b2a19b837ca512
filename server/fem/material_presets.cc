#include <array>
#include <string>

#include "server/fem/material.h"

namespace kerf::fem {
namespace {

struct Preset {
  std::string_view name;
  Material material;
};

// Fields in declaration order: E1, E2 (Pa), nu12, G (Pa), direction (rad), thickness (m), density (kg/m^3),
// bending_scale, mass_damping (1/s), stiffness_damping (s).
//
// Only `wool` is a published parameter set. The others are declared: orders of magnitude from the literature named,
// rounded, meant to look and feel like the thing, not to predict a sample of it.
constexpr std::array<Preset, 7> kPresets{{
    // Light, soft cloth that one core steps in real time at 50x50: E t = 200 N/m, 0.2 kg/m^2.
    {"demo", {4.0e5, 4.0e5, 0.3, 1.5385e5, 0.0, 5.0e-4, 400.0, 1.0, 0.2, 2.0e-5}},
    // Wool of the thesis Kerf starts from: E 3.1 GPa, G 0.51 GPa, nu 0.63 (above 0.5: woven, not isotropic), 0.5 mm.
    {"wool", {3.1e9, 3.1e9, 0.63, 0.51e9, 0.0, 5.0e-4, 1300.0, 1.0, 0.0, 0.0}},
    // Plain-weave cotton, 150 g/m^2: low-load tensile and shear stiffness and bending rigidity (~1e-5 N m) of the order
    // of KES-F measurements (Kawabata 1980, The Standardization and Analysis of Hand Evaluation).
    {"cotton", {4.0e7, 3.0e7, 0.25, 1.5e5, 0.0, 4.0e-4, 375.0, 0.04, 0.1, 1.0e-5}},
    // Silk habutai, 50 g/m^2, bending rigidity ~2e-6 N m; same kind of source.
    {"silk", {8.0e7, 6.0e7, 0.2, 2.0e5, 0.0, 1.2e-4, 420.0, 0.15, 0.1, 1.0e-5}},
    // Vulcanised natural rubber: nearly incompressible; E as in Treloar 1975, The Physics of Rubber Elasticity.
    {"rubber", {1.5e6, 1.5e6, 0.49, 5.0336e5, 0.0, 1.0e-3, 950.0, 1.0, 0.1, 1.0e-4}},
    // Copy paper, 80 g/m^2, axis 1 along the machine direction; G = 0.387 sqrt(E1 E2) (Baum, Brennan, Habeger 1981).
    {"paper", {5.5e9, 2.7e9, 0.3, 1.49e9, 0.0, 1.0e-4, 800.0, 1.0, 0.2, 1.0e-6}},
    // Human skin at small strain, in vivo: E 0.4-0.9 MPa (Agache et al. 1980).
    {"skin", {5.0e5, 5.0e5, 0.48, 1.6892e5, 0.0, 1.5e-3, 1100.0, 1.0, 0.5, 5.0e-4}},
}};

constexpr std::array<std::string_view, kPresets.size()> make_names() {
  std::array<std::string_view, kPresets.size()> names;
  for (std::size_t i = 0; i < kPresets.size(); ++i) names[i] = kPresets[i].name;
  return names;
}
constexpr std::array<std::string_view, kPresets.size()> kNames = make_names();

}  // namespace

Result<Material> find_preset(std::string_view name) {
  for (const Preset& preset : kPresets) {
    if (preset.name == name) return preset.material;
  }
  std::string known;
  for (const std::string_view known_name : kNames) {
    if (!known.empty()) known += ", ";
    known += known_name;
  }
  return Error{ErrorCode::kNotFound, "MATERIAL_UNKNOWN",
               "no material \"" + std::string(name) + "\"; there are " + known, "material.preset"};
}

std::span<const std::string_view> preset_names() {
  return kNames;
}

}  // namespace kerf::fem
