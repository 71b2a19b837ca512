#include "server/core/fem/step/softening.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include <Eigen/Geometry>

#include "server/core/fem/model/model.h"
#include "server/core/fem/step/automatic_integrator.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

// Largest distance to the sheet with factor 1 after 0.3 s, over the side of the sheet. Measured with wool, paper and
// foil, which hardly stretch.
struct MeasuredError {
  int factor;
  double error;  // -
};
constexpr std::array<MeasuredError, 5> kMeasured{{{1, 0.0}, {2, 0.8e-3}, {4, 0.8e-3}, {8, 1.1e-3}, {16, 2.0e-3}}};

// Returns the larger side of the sheet in material coordinates, m.
double size_of(const mesh::TriangleMesh& mesh) {
  Eigen::AlignedBox2d box;
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) box.extend(mesh.rest_position(v));
  return box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
}

}  // namespace

Material soften(Material material, int factor) {
  material.youngs_modulus_1 /= factor;
  material.youngs_modulus_2 /= factor;
  material.shear_modulus /= factor;
  material.bending_scale *= factor;
  return material;
}

std::vector<Material> soften(std::vector<Material> materials, int factor) {
  for (Material& material : materials) material = soften(std::move(material), factor);
  return materials;
}

double expected_error(int factor, std::span<const Material> materials, double size, double gravity) {
  const auto* measured = std::find_if(kMeasured.begin(), kMeasured.end(),
                                      [factor](const MeasuredError& row) { return row.factor == factor; });
  double stretch = 0.0;
  for (const Material& m : materials) {
    const double stiffness = std::min(m.youngs_modulus_1, m.youngs_modulus_2);
    // Twice the stretch of a strip that hangs at rest under its own weight.
    stretch = std::max(stretch, m.density * gravity * size * size / stiffness);
  }
  return measured->error * size + (factor - 1) * stretch;
}

Softening choose_softening(const mesh::TriangleMesh& mesh, std::span<const Material> materials, MembraneLaw law,
                           const IntegratorOptions& options, double gravity) {
  const std::vector<Material> given(materials.begin(), materials.end());
  Softening exact;
  Softening choice;
  for (const MeasuredError& row : kMeasured) {
    choice.factor = row.factor;
    const TickEstimate estimate = estimate_tick(Model(mesh, soften(given, row.factor), law), options);
    choice.is_explicit = estimate.is_explicit;
    choice.cost = 1e-9 * (estimate.is_explicit ? estimate.explicit_ns : estimate.implicit_ns);
    choice.budget = kShareOfTick * options.tick;
    if (row.factor == 1) exact = choice;
    if (choice.fits()) break;
  }
  if (!choice.is_explicit) return exact;
  choice.expected_error = expected_error(choice.factor, materials, size_of(mesh), gravity);
  return choice;
}

std::string describe(const Softening& softening) {
  std::array<char, 256> text{};
  const char* cost_of = softening.is_explicit ? "explicit" : "implicit";
  if (softening.factor == 1) {
    const char* verdict = softening.fits()        ? "which fits"
                          : softening.is_explicit ? "which does not fit"
                                                  : "which softening would not reduce";
    std::snprintf(text.data(), text.size(),
                  "real time: membrane as given; a tick of %s steps is estimated at %.1f ms of %.1f ms, %s", cost_of,
                  softening.cost * 1e3, softening.budget * 1e3, verdict);
  } else {
    std::snprintf(text.data(), text.size(),
                  "real time: membrane %d times softer, bending kept; a tick is estimated at %.1f ms of %.1f ms%s; "
                  "expected error %.3g mm after 0.3 s at a flat boundary",
                  softening.factor, softening.cost * 1e3, softening.budget * 1e3,
                  softening.fits() ? "" : ", which still does not fit: use a coarser mesh",
                  softening.expected_error * 1e3);
  }
  return text.data();
}

}  // namespace kerf::fem
