#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "server/base/phase_observer.h"
#include "server/base/result.h"
#include "server/base/state_hash.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/mesh/mesh_revert.h"
#include "server/core/sheet/checkpoint.h"
#include "server/core/sheet/grab_set.h"
#include "server/core/sheet/initial_state.h"
#include "server/core/sheet/time_stepper.h"
#include "server/core/sheet/vertex_ancestry.h"

namespace kerf::sheet {

// The sheet as a body: mesh, model and state, what acts on it, and the stepper that moves it. It knows neither ticks
// nor the commands and cuts that came before. Copies need rebuild_integrator() before their first step.
class MovingSheet {
 public:
  MovingSheet(std::shared_ptr<const InitialState> initial, IntegratorFactory make_integrator);

  // Sets constraints and loads for a step of `duration` (s, 0: at once) that ends at `end`; does nothing if none
  // changed.
  void set_conditions(const Instant& end, double duration);
  // Sets them again for the present instant if they were changed.
  void refresh_conditions();
  // Sets all loads for a step of a tick that ends at `time` (s).
  void set_loads(double time);
  // Advances by a tick, under the loads set before it. An interrupted step leaves state and conditions as they were at
  // `before`.
  StepOutcome step(const StopConditions& stop, const Instant& before);
  // Watches for rest after a step. more_to_come: commands of the scene are still to come.
  void watch_rest(bool more_to_come);
  void disturb() { stepper_.disturb(); }
  void prepare() { stepper_.prepare(); }
  void rebuild_integrator() { stepper_.rebuild_integrator(model_); }

  // See Sheet::settle(), Sheet::bend_by_angles().
  fem::EquilibriumStats settle(double load, const fem::EquilibriumOptions& options, const fem::EquilibriumWatch& watch);
  void bend_by_angles() { model_.bend_by_angles(mesh_); }

  // Commands. Each changes everything it should, or nothing.
  Status grab(const Grab& grab) { return grabs_.add(grab, mesh_, model_, state_.x, dt_); }
  Status drag(const Drag& drag) { return grabs_.drag(drag); }
  Status release(const Release& release) { return grabs_.release(release); }
  Status set_pins(const SetPins& pins);
  void set_gravity(const Eigen::Vector3d& value) { conditions_.set_gravity(value); }
  void set_wind(const Wind& value);
  Status set_material(const SetMaterial& change);

  // The mesh, for an edit. follow() or revert() must come next.
  [[nodiscard]] mesh::TriangleMesh& mesh_to_edit() { return mesh_; }
  // Brings everything else up to date with edits that the mesh has made. Returns true if other vertices are pinned.
  // `rewritten`: slots that they rewrote; sorted, unique.
  bool follow(std::span<const mesh::MeshEdit* const> edits, const std::vector<mesh::TriangleId>& rewritten,
              PhaseObserver* observer);
  // Moves grabs off the vertices that an undo takes away. Must be called before the mesh is reverted.
  void leave_new_vertices(const VertexAncestry& ancestry) { grabs_.leave_new_vertices(ancestry, mesh_); }
  // Brings everything else up to date with an undo of edits. Returns true if other vertices are pinned. A vertex that a
  // pinned one joins is held where that was; one that was pinned itself, where it was. `lost`: pins to put back.
  bool revert(std::span<const mesh::RevertedEdit> reverted, const VertexAncestry& ancestry,
              const std::vector<mesh::TriangleId>& rewritten, std::span<const fem::Pin> lost, PhaseObserver* observer);

  [[nodiscard]] MovingState save() const;
  [[nodiscard]] MovingState initial_state() const;
  // Goes back to another state, without grabs.
  void restore(const MovingState& to);

  [[nodiscard]] const SheetConfig& config() const { return *initial_->config; }
  [[nodiscard]] const InitialState& initial() const { return *initial_; }
  [[nodiscard]] const mesh::TriangleMesh& mesh() const { return mesh_; }
  [[nodiscard]] const fem::Model& model() const { return model_; }
  [[nodiscard]] const fem::State& state() const { return state_; }
  [[nodiscard]] const fem::Loads& loads() const { return conditions_.loads(); }
  [[nodiscard]] const ConditionValues& conditions() const { return conditions_.values(); }
  [[nodiscard]] const MaterialSetup& materials() const { return materials_; }
  [[nodiscard]] const PinSet& pins() const { return pins_; }
  [[nodiscard]] const GrabSet& grabs() const { return grabs_; }
  [[nodiscard]] const TimeStepper& stepper() const { return stepper_; }
  [[nodiscard]] const std::vector<mesh::VertexId>& removed() const { return removed_; }  // without material; sorted
  [[nodiscard]] fem::TickCost expected_cost() const;
  // Hashes mesh, positions, velocities, pins, grabs, loads, and materials that are not the initial ones.
  void add_to(StateHash& hash) const;

 private:
  // Holds `vertices` (sorted, unique) where they are now.
  void pin(std::vector<mesh::VertexId> vertices);
  void rebuild();
  // Updates everything else once mesh, model and state have the same topology again.
  bool finish_edit(std::vector<mesh::VertexId> now_pinned, std::span<const mesh::MeshEdit* const> edits,
                   PhaseObserver* observer);

  std::shared_ptr<const InitialState> initial_;
  double dt_;  // s

  mesh::TriangleMesh mesh_;
  fem::State state_;
  MaterialSetup materials_;
  PinSet pins_;
  std::int32_t last_pins_version_ = 0;
  GrabSet grabs_;
  SheetConditions conditions_;
  std::vector<mesh::VertexId> removed_;

  fem::Model model_;
  TimeStepper stepper_;
};

}  // namespace kerf::sheet
