#pragma once

#include <cmath>

#include "server/base/random.h"
#include "server/core/fem/element/material.h"

namespace kerf::fem {

// Orthotropic or not, stiff and soft in shear, nu of both signs; 1 mm thick. `kind`: 0..kMaterialKinds - 1.
inline Material random_material(SeededRandom& random, int kind) {
  Material m = isotropic(1.0e6, random.uniform(-0.9, 0.49), 1.0e-3, 300.0);
  m.direction = random.uniform(0.0, 3.0);
  if (kind == 0) return m;
  m.poissons_ratio_12 = 0.63;  // as in the thesis' table 4.1
  m.shear_modulus = 0.51 / 3.1 * m.youngs_modulus_1;
  if (kind == 1) return m;
  m.youngs_modulus_2 = m.youngs_modulus_1 * std::pow(10.0, random.uniform(-2.0, 2.0));
  const double largest_ratio = std::sqrt(m.youngs_modulus_1 / m.youngs_modulus_2);
  m.poissons_ratio_12 = largest_ratio * random.uniform(kind == 2 ? 0.0 : -0.95, 0.95);
  m.shear_modulus = std::sqrt(m.youngs_modulus_1 * m.youngs_modulus_2) * std::pow(10.0, random.uniform(-2.0, 1.0));
  return m;
}
inline constexpr int kMaterialKinds = 4;

}  // namespace kerf::fem
