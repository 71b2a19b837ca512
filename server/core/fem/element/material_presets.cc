#include <array>
#include <string>

#include "server/core/fem/element/material.h"

namespace kerf::fem {
namespace {

struct Preset {
  std::string_view name;
  Material material;
};

// Fields in declaration order: E1, E2 (Pa), nu12, G (Pa), direction (rad), thickness (m), density (kg/m^3),
// bending_scale, mass_damping (1/s), stiffness_damping (s), strain_limit.
//
// Each comment says which numbers are measured. Damping is never measured: where it is not 0, it is chosen. KES-F
// units: 1 gf cm^2/cm = 9.807e-5 N m of bending, 1 gf/(cm degree) = 56.19 N/m of shear, 1 gf cm/cm^2 = 0.9807 N/m of
// energy. bending_scale makes D11 = bending_scale C11 t^2 / 12 the given bending rigidity.
// strain_limit is about the extension at which typical samples break: wool fibres 0.3, silk fibres 0.2, cotton fabric
// with its crimp 0.15, denim 0.2. Morton, Hearle, Physical Properties of Textile Fibres, give 0.3, 0.23 and 0.07 for
// wool, silk and cotton fibres. Copy paper has 0.02 along the machine direction, soft foil 0.02. Skin has 0.54 (Ni
// Annaidh et al. 2012, Characterization of the Anisotropic Mechanical Properties of Excised Human Skin). Rubber and
// `demo` stretch further than Kerf's linear law is meant for; at their limits of 1 and 0.5 the law is plainly wrong.
constexpr std::array<Preset, 9> kPresets{{
    // No real material: light, soft cloth that one core steps in real time at 50x50: E t = 200 N/m, 0.2 kg/m^2.
    {"demo", {4.0e5, 4.0e5, 0.3, 1.5385e5, 0.0, 5.0e-4, 400.0, 1.0, 0.2, 2.0e-5, 0.5}},
    // Published: wool of the thesis Kerf starts from, Table 4.1: E 3.1 GPa, G 0.51 GPa, nu 0.63 (above 0.5: woven, not
    // isotropic), 1300 kg/m^3, 0.5 mm. The moduli are those of the fibre rather than of a fabric: KES-F gives values
    // some hundred times lower for cloth. It bends like a solid plate.
    {"wool", {3.1e9, 3.1e9, 0.63, 0.51e9, 0.0, 5.0e-4, 1300.0, 1.0, 0.0, 0.0, 0.3}},
    // Typical, not one particular fabric: plain-weave shirting, 150 g/m^2, with E t = 16 and 12 kN/m (an extension of
    // about 3 and 4 % at 500 gf/cm). Shear is 1.07 gf/(cm degree), bending 0.09 gf cm^2/cm (9e-6 N m). Both are of the
    // order of KES-F measurements (Kawabata 1980, The Standardization and Analysis of Hand Evaluation). nu is assumed.
    {"cotton", {4.0e7, 3.0e7, 0.25, 1.5e5, 0.0, 4.0e-4, 375.0, 0.04, 0.1, 1.0e-5, 0.15}},
    // Measured by KES-F, mean of warp and weft: sample A of "Regenerated Cellulose-Based Denim Fabric for Tropical
    // Regions", Journal of Textiles 2016, 4614168, Table 5. Its extension is 5.515 % at 500 gf/cm with linearity 0.712,
    // shear 2.180 gf/(cm degree), bending 0.172 gf cm^2/cm, thickness 1.066 mm. Derived: E t = 6.33 kN/m, which gives
    // the measured energy 9.82 gf cm/cm^2 at that extension. The mass, 0.324 kg/m^2, was measured on another fabric: 11
    // oz black denim of Wang, O'Brien, Ramamoorthi 2011, Data-Driven Elastic Models for Cloth. nu is assumed.
    {"denim", {5.938e6, 5.938e6, 0.2, 1.149e5, 0.0, 1.066e-3, 304.0, 0.027, 0.1, 1.0e-5, 0.2}},
    // Typical, not one particular fabric: habutai, 50 g/m^2, with E t = 9.6 and 7.2 kN/m. Shear 0.43 gf/(cm degree) and
    // bending 0.018 gf cm^2/cm (1.8e-6 N m) are also of the order of KES-F measurements. nu is assumed.
    {"silk", {8.0e7, 6.0e7, 0.2, 2.0e5, 0.0, 1.2e-4, 420.0, 0.15, 0.1, 1.0e-5, 0.2}},
    // Vulcanised natural rubber at small strain, rounded: nearly incompressible, E as in Treloar 1975, The Physics of
    // Rubber Elasticity. The thickness is assumed. Kerf's law does not soften at large strain as rubber does.
    {"rubber", {1.5e6, 1.5e6, 0.49, 5.0336e5, 0.0, 1.0e-3, 950.0, 1.0, 0.1, 1.0e-4, 1.0}},
    // Copy paper, 80 g/m^2, axis 1 along the machine direction: typical moduli; G = 0.387 sqrt(E1 E2), the relation
    // measured by Baum, Brennan, Habeger 1981, Orthotropic Elastic Constants of Paper.
    {"paper", {5.5e9, 2.7e9, 0.3, 1.49e9, 0.0, 1.0e-4, 800.0, 1.0, 0.2, 1.0e-6, 0.02}},
    // Human skin at small strain, in vivo: within E 0.4-0.9 MPa as measured in torsion by Agache et al. 1980,
    // Mechanical Properties and Young's Modulus of Human Skin in Vivo. nu, thickness and density are typical.
    {"skin", {5.0e5, 5.0e5, 0.48, 1.6892e5, 0.0, 1.5e-3, 1100.0, 1.0, 0.5, 5.0e-4, 0.54}},
    // Household aluminium foil, unalloyed or nearly so (1100, 1145, 1235; 8011 is within a few per cent): E 69 GPa, nu
    // 0.33, 2710 kg/m^3 of ASM Handbook volume 2, Properties of Wrought Aluminum. 16 um is a usual thickness. Elastic
    // only: real foil stays folded, this one springs back.
    {"foil", {6.9e10, 6.9e10, 0.33, 2.594e10, 0.0, 1.6e-5, 2710.0, 1.0, 0.1, 0.0, 0.02}},
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
  return not_found("MATERIAL_UNKNOWN", "there is no material \"" + std::string(name) + "\"; the presets are " + known,
                   "material.preset");
}

std::span<const std::string_view> preset_names() {
  return kNames;
}

}  // namespace kerf::fem
