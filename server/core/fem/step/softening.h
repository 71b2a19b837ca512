#pragma once

#include <span>
#include <string>
#include <vector>

#include "server/core/fem/element/material.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {

// A membrane made softer, so that explicit steps of the sheet fit its tick.
struct Softening {
  int factor = 1;               // -, 1, 2, 4, 8 or 16: what the membrane's moduli are divided by
  bool is_explicit = true;      // how such a sheet is stepped, uncut
  double cost = 0.0;            // s, counted, of a tick with that factor
  double budget = 0.0;          // s, the share of the tick that the cost has to fit
  double expected_error = 0.0;  // m, >= 0, see expected_error(); 0 with factor 1

  [[nodiscard]] bool fits() const { return cost <= budget; }
};

// Takes the least factor of which the counted cost fits 0.8 of options.tick, or 16 where none does. Counts are those
// of AutomaticIntegrator, nothing is timed: the same arguments give the same choice on every machine. The factor is 1
// where even the softest sheet would be stepped implicitly, as such steps cost the same at any stiffness. `materials`:
// one for each region of the mesh, 1..kMaxMaterials. gravity: m/s^2, >= 0, its magnitude. Builds up to five models.
Softening choose_softening(const mesh::TriangleMesh& mesh, std::span<const Material> materials, MembraneLaw law,
                           const IntegratorOptions& options, double gravity);

// Divides the moduli by a power of two; bending stays the same, bit for bit.
Material soften(Material material, int factor);
std::vector<Material> soften(std::vector<Material> materials, int factor);

// m, >= 0, the largest distance expected after 0.3 s from explicit steps of the materials as given. The first part was
// measured of flat sheets of 1 m held by a straight edge, and grows with `size` (m, the larger side). The second is
// what gravity (m/s^2) stretches a strip of that length more than before, along the softer axis of the softest
// material, let go suddenly.
double expected_error(int factor, std::span<const Material> materials, double size, double gravity);

// Describes the choice, its cost and its error in one clause for people.
std::string describe(const Softening& softening);

}  // namespace kerf::fem
