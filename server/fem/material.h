#pragma once

#include <span>
#include <string_view>

#include <Eigen/Core>

#include "server/base/result.h"

namespace kerf::fem {

// Orthotropic plane-stress sheet material with an independent shear modulus (Jones, Mechanics of Composite Materials,
// eq. 2.65 ff.). Immutable once a Model is built from it. Material axis 1 is the warp or fibre direction.
struct Material {
  double youngs_modulus_1 = 4.0e5;  // Pa, in (0, 1e13], along material axis 1
  double youngs_modulus_2 = 4.0e5;  // Pa, in (0, 1e13], along material axis 2
  double poissons_ratio_12 = 0.3;   // -, contraction along 2 under tension along 1; nu12^2 E2 / E1 < 1 suffices,
                                    // because the shear modulus is independent
  double shear_modulus = 1.5385e5;  // Pa, in (0, 1e13]
  double direction = 0.0;           // rad, |direction| <= 2 pi, angle of axis 1 against rest x
  double thickness = 5.0e-4;        // m, in [1e-6, 1]
  double density = 400.0;           // kg/m^3, in [1e-2, 1e5]
  double bending_scale = 1.0;       // -, in [0, 1e3]; 1 is the plate value C t^2 / 12, 0 switches bending off. Woven
                                    // cloth bends far more easily than a plate of its membrane stiffness: ~0.01
  double mass_damping = 0.0;        // 1/s, in [0, 1e4], Rayleigh alpha: force -alpha m v
  double stiffness_damping = 0.0;   // s, in [0, 10], Rayleigh beta: stress C (e + beta de/dt). The explicit integrator
                                    // limits it to what its step can carry (see integrator.h)

  bool operator==(const Material&) const = default;
};

// E1 = E2 = E, G = E / (2 (1 + nu)); no damping, full plate bending.
Material isotropic(double youngs_modulus, double poissons_ratio, double thickness, double density);

// Every field finite and in the range above, else INVALID_ARGUMENT with the field path below `prefix`, e.g.
// "material.youngs_modulus_1_pa".
Status validate(const Material& material, std::string_view prefix = "material");

// Membrane law C in N/m (thickness included), in material axes, for Voigt strain (e11, e22, 2 e12). Symmetric positive
// definite for a valid material.
Eigen::Matrix3d membrane_law(const Material& material);

// Plate law D = bending_scale C t^2 / 12 in N m, for Voigt curvature (k11, k22, 2 k12).
Eigen::Matrix3d bending_law(const Material& material);

// Declared materials by name; NOT_FOUND lists the names. Values and their sources: material.cc.
Result<Material> find_preset(std::string_view name);
std::span<const std::string_view> preset_names();

}  // namespace kerf::fem
