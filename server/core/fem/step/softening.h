#pragma once

#include <span>
#include <string>
#include <vector>

#include "server/core/fem/element/material.h"
#include "server/core/fem/step/integrator_options.h"

namespace kerf::mesh {
class TriangleMesh;
}

namespace kerf::fem {

// A membrane made softer, so that explicit steps of the sheet fit into its tick.
struct Softening {
  int factor = 1;               // -, 1, 2, 4, 8 or 16: divisor of the membrane's moduli
  bool is_explicit = true;      // the uncut softened sheet is stepped explicitly
  double cost = 0.0;            // s, estimated computing time of a tick with `factor`
  double budget = 0.0;          // s, computing time that a tick may use: a part of its duration
  double expected_error = 0.0;  // m, >= 0, see expected_error(); 0 with factor 1

  [[nodiscard]] bool fits() const { return cost <= budget; }
};

// Chooses the least factor whose estimated cost fits 0.8 of options.tick, or 16 if none does. Estimates are those of
// AutomaticIntegrator and nothing is timed, so the same arguments give the same choice on every machine. The factor is
// 1 if even the softest sheet would be stepped implicitly, since such steps cost the same at any stiffness.
// `materials`: one for each region of the mesh, 1..kMaxMaterials. gravity: m/s^2, >= 0, its magnitude. Builds up to
// five models.
Softening choose_softening(const mesh::TriangleMesh& mesh, std::span<const Material> materials, MembraneLaw law,
                           const IntegratorOptions& options, double gravity);

// Divides the moduli by `factor`, a power of two. Bending stays the same, bit for bit.
Material soften(Material material, int factor);
std::vector<Material> soften(std::vector<Material> materials, int factor);

// Returns the largest distance (m, >= 0) expected after 0.3 s from explicit steps of the original materials. It is the
// sum of two parts. The first was measured on flat sheets of 1 m held by a straight edge, and is in proportion to
// `size` (m, the larger side). The second is the additional stretch of a strip of length `size` that is suddenly
// released under gravity (m/s^2). It is cut along the softer axis of the material that stretches most.
double expected_error(int factor, std::span<const Material> materials, double size, double gravity);

// Describes the choice, its cost and its error in one clause for people.
std::string describe(const Softening& softening);

}  // namespace kerf::fem
