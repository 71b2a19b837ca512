#pragma once

#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "server/base/result.h"

namespace kerf::fem {

// A closed interval.
struct Range {
  double low = 0.0;
  double high = 0.0;
};

// Ranges of the fields of Material, in their units; requests use them too.
struct MaterialRanges {
  static constexpr Range kYoungsModulus{1e-6, 1e12};
  static constexpr Range kPoissonsRatio12{-1e3, 1e3};  // Material::poissons_ratio_12 states a further limit
  static constexpr Range kShearModulus{1e-7, 1e13};    // includes those of isotropic sheets nearly down to nu = -1
  static constexpr Range kDirection{-6.283185307179587, 6.283185307179587};
  static constexpr Range kThickness{1e-6, 1.0};
  static constexpr Range kDensity{1e-2, 1e5};
  static constexpr Range kBendingScale{0.0, 1e3};
  // From the plate stiffness of the softest and thinnest material to that of the hardest and thickest one at the
  // largest bending_scale.
  static constexpr Range kBendingStiffness{1e-25, 1e14};
  static constexpr Range kBendingCoupling{-1e14, 1e14};
  static constexpr Range kMassDamping{0.0, 1e3};
  static constexpr Range kStiffnessDamping{0.0, 1.0};
  static constexpr Range kStrainLimit{1e-6, 1e3};
};

// Strain measure of the membrane in which stress is linear; formulas in membrane.h. One law holds for a whole sheet;
// its materials give the moduli. For small strains both laws are the same.
enum class MembraneLaw {
  kCorotational,  // Biot strain U - I, F = R U: a strip under tension is linear at any stretch
  kGreen,  // Green strain (F^T F - I) / 2: the Saint Venant-Kirchhoff material. Cheaper; a strip stretched to lambda
           // times its length pulls lambda (lambda + 1) / 2 times as hard, and below 0.58 it resists ever less
};

// Orthotropic plane-stress sheet material with an independent shear modulus (Jones, Mechanics of Composite Materials,
// eq. 2.65 ff.). MaterialRanges limits the fields. Immutable once a Model is built from it. Material axis 1 is the warp
// or fibre direction.
struct Material {
  double youngs_modulus_1 = 4.0e5;  // Pa, along material axis 1
  double youngs_modulus_2 = 4.0e5;  // Pa, along material axis 2
  double poissons_ratio_12 = 0.3;   // -, contraction along 2 under tension along 1; must have nu12^2 E2 / E1 < 1, which
                                    // makes the law positive definite
  double shear_modulus = 1.5385e5;  // Pa
  double direction = 0.0;           // rad, angle of axis 1 against rest x
  double thickness = 5.0e-4;        // m
  double density = 400.0;           // kg/m^3
  double bending_scale = 1.0;       // -; 1 is the plate value C t^2 / 12, 0 switches bending off. Woven cloth bends far
                                    // more easily than a plate of its membrane stiffness: ~0.01
  double mass_damping = 0.0;        // 1/s, Rayleigh alpha: force -alpha m v
  double stiffness_damping = 0.0;   // s, Rayleigh beta: stress C (e + beta de/dt). The explicit integrator limits it by
                                    // its step (see integrator.h)
  double strain_limit = 0.5;        // -, largest |principal strain| that the material bears; larger ones are only
                                    // reported
  // N m: measured entries of the plate law in material axes. M11 = D11 k11 + D12 k22, M22 = D12 k11 + D22 k22, M12 =
  // D66 2 k12. The law has the entry of bending_scale C t^2 / 12 for each that is absent.
  std::optional<double> bending_stiffness_1{};  // D11
  std::optional<double> bending_stiffness_2{};  // D22
  std::optional<double> bending_coupling{};     // D12, D12^2 < D11 D22
  std::optional<double> twisting_stiffness{};   // D66

  bool operator==(const Material&) const = default;
};

// Returns a material with E1 = E2 = E, G = E / (2 (1 + nu)), no damping and full plate bending.
Material isotropic(double youngs_modulus, double poissons_ratio, double thickness, double density);

// Checks every field against MaterialRanges. Returns INVALID_ARGUMENT with the field path below `prefix`, e.g.
// "material.youngs_modulus_pa".
Status validate(const Material& material, std::string_view prefix = "material");

// Returns the membrane law C in N/m (thickness included), in material axes, for Voigt strain (e11, e22, 2 e12). It is
// symmetric positive definite for a valid material.
Eigen::Matrix3d membrane_law(const Material& material);

// Returns the plate law D in N m, in material axes, for Voigt curvature (k11, k22, 2 k12). Entries that the material
// does not give are those of bending_scale C t^2 / 12. It is symmetric positive definite, or 0, for a valid material.
Eigen::Matrix3d bending_law(const Material& material);

// Returns a material with the same membrane and no bending stiffness.
Material without_bending(Material material);

// Finds a preset by name; NOT_FOUND lists the names. For values and their sources see material_presets.cc.
Result<Material> find_preset(std::string_view name);
std::span<const std::string_view> preset_names();

}  // namespace kerf::fem
