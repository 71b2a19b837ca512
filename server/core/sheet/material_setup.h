#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/base/result.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/softening.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/scene/sheet_materials.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// The materials of a sheet, and the softening of its membrane (Fidelity::kRealTime). A value that is cheap to copy. All
// functions must get the config with which it was made.
class MaterialSetup {
 public:
  // Chooses the softening for the uncut mesh. There is none if the fidelity is kExact or the analysis is not
  // DynamicAnalysis. touches_itself: true if self-contact is on.
  MaterialSetup(scene::SheetMaterials materials, const scene::SheetConfig& config, bool touches_itself,
                const mesh::TriangleMesh& uncut);

  // Returns the setup with the material of one part, or of all parts, replaced. Errors: those of with_material().
  [[nodiscard]] Result<MaterialSetup> with(const scene::SetMaterial& change, const scene::SheetConfig& config,
                                           bool touches_itself, const mesh::TriangleMesh& uncut) const;

  // Makes the model of a mesh with these materials, softened if there is a softening.
  [[nodiscard]] fem::Model make_model(const scene::SheetConfig& config, const mesh::TriangleMesh& mesh) const;

  [[nodiscard]] const scene::SheetMaterials& materials() const { return *materials_; }
  [[nodiscard]] const std::shared_ptr<const scene::SheetMaterials>& shared() const { return materials_; }
  [[nodiscard]] const std::vector<fem::Material>& by_region() const { return materials_->by_region; }
  [[nodiscard]] const std::optional<fem::Softening>& softening() const { return softening_; }
  [[nodiscard]] double half_thickness() const { return 0.5 * scene::greatest_thickness(by_region()); }  // m
  // Returns true if any material has mass or stiffness damping.
  [[nodiscard]] bool is_damped() const;

 private:
  friend struct Fields<MaterialSetup>;
  std::shared_ptr<const scene::SheetMaterials> materials_;
  std::optional<fem::Softening> softening_;
};

// Refuses a sheet to be stepped in time whose steps double precision cannot solve: kInvalidArgument SHEET_TOO_STIFF.
// `prefix`: path of the material in the error ("material").
Status check_condition(const scene::SheetConfig& config, const fem::Model& model, const std::string& prefix);

// Returns the mass (kg) of all solid triangles. O(slots).
double rest_mass(const mesh::TriangleMesh& mesh, const std::vector<fem::Material>& by_region);

}  // namespace kerf::sheet
