// Another material while the sheet runs, which materials can be stepped at all, and how they are softened.

#include <optional>
#include <utility>
#include <vector>

#include "server/core/fem/model/condition.h"
#include "server/core/fem/step/softening.h"
#include "server/core/scene/integrator_settings.h"
#include "server/core/scene/sheet_materials.h"
#include "server/core/sheet/sheet_impl.h"

namespace kerf::sheet {

Status check_condition(const SheetConfig& config, const fem::Model& model, const std::string& prefix) {
  const double condition = fem::condition_number(model, 1.0 / config.tick_rate_hz);
  const bool moves = std::holds_alternative<DynamicAnalysis>(config.analysis);
  if (!moves || fem::rate_condition(condition) != fem::ConditionClass::kRefused) return Nothing{};
  return invalid_argument(
      "SHEET_TOO_STIFF",
      fem::describe_condition(condition) +
          ": steps of this length would be dominated by rounding; make the material softer or heavier, the "
          "mesh coarser, or the tick rate higher",
      prefix + ".youngs_modulus_pa");
}

std::optional<fem::Softening> choose_softening(const SheetConfig& config, const mesh::TriangleMesh& uncut,
                                               const std::vector<fem::Material>& by_region) {
  const bool moves = std::holds_alternative<DynamicAnalysis>(config.analysis);
  if (config.fidelity == Fidelity::kExact || !moves) return std::nullopt;
  return fem::choose_softening(uncut, by_region, config.membrane_law,
                               integrator_options(config.integrator, 1.0 / config.tick_rate_hz), config.gravity.norm());
}

fem::Model make_model(const SheetConfig& config, const mesh::TriangleMesh& mesh,
                      const std::vector<fem::Material>& by_region, const std::optional<fem::Softening>& softening) {
  return {mesh, softening ? fem::soften(by_region, softening->factor) : by_region, config.membrane_law};
}

Status Sheet::Impl::set_material(const SetMaterial& change) {
  SetMaterial wanted = change;
  if (config->planar) wanted.material = fem::without_bending(wanted.material);
  KERF_TRY_ASSIGN(SheetMaterials changed, with_material(*materials, wanted));
  const std::optional<fem::Softening> chosen = choose_softening(*config, initial->built.mesh, changed.by_region);
  fem::Model made = make_model(*config, mesh, changed.by_region, chosen);
  if (held_vertices.has_slopes()) made.set_clamps(mesh, held_vertices.clamps(now));
  KERF_TRY(check_condition(*config, made, "set_material.material"));
  materials = std::make_shared<const SheetMaterials>(std::move(changed));
  softening = chosen;
  model = std::move(made);
  last_counts.reset();
  contact.set_half_thickness(0.5 * greatest_thickness(materials->by_region));
  for (GrabState& held : grabs) {
    if (held.is_default) held.stiffness = default_stiffness(held.vertices[0]);
  }
  conditions_changed = true;  // moments at edges are those of the model
  rebuild();
  ++settings_version;
  return Nothing{};
}

}  // namespace kerf::sheet
