#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/applied_forces.h"
#include "server/core/scene/held_vertices.h"
#include "server/core/scene/sheet_config.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// The values from which the constraints and loads of a sheet follow at any instant.
struct ConditionValues {
  scene::Wind wind;
  Eigen::Vector3d full_gravity;  // m/s^2, gravity when the factor of gravity_history is 1
  scene::HeldVertices held_vertices;
  scene::AppliedForces applied_forces;
  scene::Instant now;  // instant for which the conditions were set last
};

// The constraints and loads of a sheet at an instant, without grabs. It follows commands and cuts. Changes of the
// values take effect with the next set(), those of the wind at once.
class SheetConditions {
 public:
  SheetConditions(std::shared_ptr<const scene::SheetConfig> config, ConditionValues values);

  // Sets constraints, loads and slopes for a step of `duration` (s) that ends at `end`. Duration 0 sets them at once,
  // without velocities. Does nothing if none changed. `pins`: all pins, sorted. Returns true if `model` now holds the
  // slopes of other vertices than before; then the integrator must be rebuilt.
  bool set(const scene::Instant& end, double duration, const std::vector<fem::Pin>& pins,
           const mesh::TriangleMesh& mesh, fem::Model& model);
  // Makes a model that was edited hold the present slopes. Returns the same as set().
  bool hold_slopes(const mesh::TriangleMesh& mesh, fem::Model& model);

  // Makes the next set() do its work even if time alone changes nothing.
  void mark_changed() { is_changed_ = true; }
  [[nodiscard]] bool is_changed() const { return is_changed_; }
  void set_gravity(const Eigen::Vector3d& value);  // m/s^2
  void set_wind(const scene::Wind& value);
  // Must be called after cuts, with their edits, and after undos, without edits. `initial`: the sheet as built.
  void follow(const mesh::TriangleMesh& mesh, std::span<const mesh::MeshEdit* const> edits,
              const scene::BuiltMesh& initial);
  // Replaces the values. The model must have been made again before, so that it holds no slopes.
  void restore(const ConditionValues& values);
  // Derives everything else after the values were set. The model holds no slopes yet.
  void resume();

  [[nodiscard]] const ConditionValues& values() const { return values_; }
  [[nodiscard]] bool has_slopes() const { return values_.held_vertices.has_slopes(); }
  // Returns true if a history, or the end of a constraint, will change a condition after the present instant.
  [[nodiscard]] bool has_changes_to_come() const;
  // Returns the present loads. `pins` has the pins and the components that constraints hold. `grabs` is set by the
  // owner, through grabs().
  [[nodiscard]] const fem::Loads& loads() const { return loads_; }
  [[nodiscard]] std::vector<fem::Grab>& grabs() { return loads_.grabs; }

 private:
  friend struct Fields<SheetConditions>;
  std::shared_ptr<const scene::SheetConfig> config_;
  ConditionValues values_;
  fem::Loads loads_;
  std::vector<mesh::VertexId> clamped_;  // vertices whose slope the model holds, sorted
  bool is_changed_ = true;               // true if something other than time has changed a condition since the last
                                         // set()
};

}  // namespace kerf::sheet
