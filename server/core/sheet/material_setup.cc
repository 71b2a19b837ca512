#include "server/core/sheet/material_setup.h"

#include <algorithm>

#include "server/core/fem/model/condition.h"
#include "server/core/scene/integrator_settings.h"

namespace kerf::sheet {

namespace {

bool is_stepped_in_time(const scene::SheetConfig& config) {
  return std::holds_alternative<scene::DynamicAnalysis>(config.analysis);
}

}  // namespace

MaterialSetup::MaterialSetup(scene::SheetMaterials materials, const scene::SheetConfig& config, bool touches_itself,
                             const mesh::TriangleMesh& uncut)
    : materials_(std::make_shared<const scene::SheetMaterials>(std::move(materials))) {
  if (config.fidelity == scene::Fidelity::kExact || !is_stepped_in_time(config)) return;
  softening_ = fem::choose_softening(uncut, by_region(), config.membrane_law,
                                     scene::integrator_options(config, touches_itself), config.gravity.norm());
}

Result<MaterialSetup> MaterialSetup::with(const scene::SetMaterial& change, const scene::SheetConfig& config,
                                          bool touches_itself, const mesh::TriangleMesh& uncut) const {
  scene::SetMaterial wanted = change;
  if (config.planar) wanted.material = fem::without_bending(wanted.material);
  KERF_TRY_ASSIGN(scene::SheetMaterials changed, scene::with_material(*materials_, wanted));
  return MaterialSetup(std::move(changed), config, touches_itself, uncut);
}

fem::Model MaterialSetup::make_model(const scene::SheetConfig& config, const mesh::TriangleMesh& mesh) const {
  return {mesh, softening_ ? fem::soften(by_region(), softening_->factor) : by_region(), config.membrane_law};
}

bool MaterialSetup::is_damped() const {
  return std::any_of(by_region().begin(), by_region().end(), [](const fem::Material& material) {
    return material.mass_damping > 0.0 || material.stiffness_damping > 0.0;
  });
}

Status check_condition(const scene::SheetConfig& config, const fem::Model& model, const std::string& prefix) {
  const double condition = fem::condition_number(model, 1.0 / config.tick_rate_hz);
  if (!is_stepped_in_time(config) || fem::rate_condition(condition) != fem::ConditionClass::kRefused) return Nothing{};
  return invalid_argument("SHEET_TOO_STIFF",
                          fem::describe_condition(condition) +
                              ": steps of this length would be all rounding; make the material softer or heavier, the "
                              "mesh coarser, or the tick rate higher",
                          prefix + ".youngs_modulus_pa");
}

double rest_mass(const mesh::TriangleMesh& mesh, const std::vector<fem::Material>& by_region) {
  double mass = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) mass += scene::surface_density(mesh, t, by_region) * mesh.area(t);
  }
  return mass;
}

}  // namespace kerf::sheet
