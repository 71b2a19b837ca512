#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "server/base/phase_observer.h"
#include "server/base/result.h"
#include "server/base/state_hash.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/mesh/mesh_revert.h"
#include "server/core/sheet/checkpoint.h"
#include "server/core/sheet/grab_set.h"
#include "server/core/sheet/initial_state.h"
#include "server/core/sheet/time_stepper.h"
#include "server/core/sheet/vertex_ancestry.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// The sheet as a mechanical body: mesh, model, state, pins, grabs, loads, and the stepper that moves it. It does not
// know the tick, or earlier commands and cuts. After a copy, rebuild_integrator() must be called before the first step.
class MovingSheet {
 public:
  MovingSheet(std::shared_ptr<const InitialState> initial, IntegratorFactory make_integrator);

  // Sets constraints and loads for a step of `duration` (s) that ends at `end`. Duration 0 sets them at once, without
  // velocities. Does nothing if none changed.
  void set_conditions(const scene::Instant& end, double duration);
  // Sets constraints and loads again for the present instant, if a command or cut has changed them.
  void refresh_conditions();
  // Sets all loads, including grabs, for a step of one tick that ends at `time` (s).
  void set_loads(double time);
  // Advances by one tick under the loads set before. An interrupted step leaves state and conditions as they were at
  // `before`.
  StepOutcome step(const StopConditions& stop, const scene::Instant& before);
  // Must be called after each step: detects rest, and damps a calm sheet, see RestWatch. `more_to_come`: true if
  // commands of the scene are still to come. `touches`: true if the sheet touched itself in it.
  void watch_rest(bool more_to_come, bool touches);
  void disturb() { stepper_.disturb(); }
  void prepare() { stepper_.prepare(); }
  void rebuild_integrator() { stepper_.rebuild_integrator(model_); }

  // See Sheet::settle(), Sheet::bend_by_angles().
  fem::EquilibriumStats settle(double load, const fem::EquilibriumOptions& options, const fem::EquilibriumWatch& watch);
  void bend_by_angles() { model_.bend_by_angles(mesh_); }

  // Commands. Each is done as a whole, or returns an error and changes nothing.
  Status grab(const scene::Grab& grab) { return grabs_.add(grab, mesh_, model_, state_.x, dt_); }
  Status drag(const scene::Drag& drag) { return grabs_.drag(drag); }
  Status release(const scene::Release& release) { return grabs_.release(release); }
  Status set_pins(const scene::SetPins& pins);
  void set_gravity(const Eigen::Vector3d& value) { conditions_.set_gravity(value); }
  void set_wind(const scene::Wind& value);
  Status set_material(const scene::SetMaterial& change);
  Status set_self_contact(const scene::SetSelfContact& change);

  // Returns the mesh, for an edit. follow() or revert() must be called next.
  [[nodiscard]] mesh::TriangleMesh& mesh_to_edit() { return mesh_; }
  // Updates everything else after edits of the mesh. Returns true if the set of pinned vertices changed. `rewritten`:
  // slots that the edits rewrote, sorted, unique.
  bool follow(std::span<const mesh::MeshEdit* const> edits, const std::vector<mesh::TriangleId>& rewritten,
              PhaseObserver* observer);
  // Moves grabs away from vertices that an undo removes. Must be called before the mesh is reverted.
  void leave_new_vertices(const VertexAncestry& ancestry) { grabs_.leave_new_vertices(ancestry, mesh_); }
  // Updates everything else after the undo of edits. Returns true if the set of pinned vertices changed. A vertex that
  // was pinned stays held where it was. A vertex that the undo joins with a pinned copy is held where the copy was.
  // `lost`: pins to put back.
  bool revert(std::span<const mesh::RevertedEdit> reverted, const VertexAncestry& ancestry,
              const std::vector<mesh::TriangleId>& rewritten, std::span<const fem::Pin> lost, PhaseObserver* observer);

  [[nodiscard]] MovingState save() const;
  [[nodiscard]] MovingState initial_state() const;
  // Returns to another state, without grabs.
  void restore(const MovingState& to);
  // Derives everything else after all members that Fields lists were set.
  void resume();

  [[nodiscard]] const scene::SheetConfig& config() const { return *initial_->config; }
  [[nodiscard]] const InitialState& initial() const { return *initial_; }
  [[nodiscard]] const mesh::TriangleMesh& mesh() const { return mesh_; }
  [[nodiscard]] const fem::Model& model() const { return model_; }
  [[nodiscard]] const fem::State& state() const { return state_; }
  [[nodiscard]] const fem::Loads& loads() const { return conditions_.loads(); }
  [[nodiscard]] const ConditionValues& conditions() const { return conditions_.values(); }
  [[nodiscard]] const MaterialSetup& materials() const { return materials_; }
  [[nodiscard]] const scene::SelfContact& self_contact() const { return stepper_.contact().self_contact(); }
  // Returns the most by which the flip of an edge may move the sheet in a cut; absent if folds may pass through each
  // other anyway. `is_apart` gets the flags that the limit refers to.
  [[nodiscard]] std::optional<cut::ShiftLimit> most_shift_in_cuts(std::vector<std::uint8_t>& is_apart);
  [[nodiscard]] const PinSet& pins() const { return pins_; }
  [[nodiscard]] const GrabSet& grabs() const { return grabs_; }
  [[nodiscard]] const TimeStepper& stepper() const { return stepper_; }
  [[nodiscard]] const std::vector<mesh::VertexId>& removed() const { return removed_; }  // without material
  [[nodiscard]] fem::TickCost expected_cost() const;
  // Hashes mesh, positions, velocities, held vertices, grabs, gravity, wind, and materials and self-contact if they are
  // not the initial ones.
  void add_to(StateHash& hash) const;

 private:
  friend struct Fields<MovingSheet>;
  // Pins exactly `vertices` (sorted, unique), each where it is now.
  void pin(std::vector<mesh::VertexId> vertices);
  void rebuild();
  // Updates everything else after an edit, when mesh, model and state have the same topology again. Returns true if the
  // set of pinned vertices changed.
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
