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

namespace kerf::sheet {

// Values that decide the conditions of a sheet at any instant.
struct ConditionValues {
  Wind wind;
  Eigen::Vector3d full_gravity;  // m/s^2, at factor 1
  HeldVertices held_vertices;
  AppliedForces applied_forces;
  Instant now;  // when the conditions were set last
};

// The constraints and loads of a sheet at an instant, apart from grabs. Follows commands and cuts. Changes of the
// values come into force with the next set(); changes of the wind at once.
class SheetConditions {
 public:
  SheetConditions(std::shared_ptr<const SheetConfig> config, ConditionValues values);

  // Sets constraints, loads and slopes for a step of `duration` (s, 0: at once) that ends at `end`. Does nothing if
  // none changed. `pins`: whole, sorted. Returns true if `model` holds the slopes of other vertices than before, so
  // that the integrator must be rebuilt.
  bool set(const Instant& end, double duration, const std::vector<fem::Pin>& pins, const mesh::TriangleMesh& mesh,
           fem::Model& model);
  // Makes a model that was edited hold the slopes in force. Returns the same as set().
  bool hold_slopes(const mesh::TriangleMesh& mesh, fem::Model& model);

  // Notes a change that the next set() must not pass over.
  void mark_changed() { is_changed_ = true; }
  [[nodiscard]] bool is_changed() const { return is_changed_; }
  void set_gravity(const Eigen::Vector3d& value);  // m/s^2
  void set_wind(const Wind& value);
  // Follows cuts, or the undo of some (without edits then).
  void follow(const mesh::TriangleMesh& mesh, std::span<const mesh::MeshEdit* const> edits, const BuiltMesh& initial);
  // Replaces the values. The model must have been rebuilt, so that it holds no slopes.
  void restore(const ConditionValues& values);

  [[nodiscard]] const ConditionValues& values() const { return values_; }
  [[nodiscard]] bool has_slopes() const { return values_.held_vertices.has_slopes(); }
  // Returns true if a history still changes a condition after the present instant.
  [[nodiscard]] bool has_changes_to_come() const;
  // Loads in force: pins, and over them the vertices held by constraints. Its grabs are the owner's.
  [[nodiscard]] const fem::Loads& loads() const { return loads_; }
  [[nodiscard]] std::vector<fem::Grab>& grabs() { return loads_.grabs; }

 private:
  std::shared_ptr<const SheetConfig> config_;
  ConditionValues values_;
  fem::Loads loads_;
  std::vector<mesh::VertexId> clamped_;  // whose slope the model holds; sorted
  bool is_changed_ = true;               // since the last set(), other than by time
};

}  // namespace kerf::sheet
