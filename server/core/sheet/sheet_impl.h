#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/core/cut/cut.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/fem/step/softening.h"
#include "server/core/scene/applied_forces.h"
#include "server/core/scene/held_vertices.h"
#include "server/core/scene/lineage.h"
#include "server/core/scene/mesh_source.h"
#include "server/core/sheet/checkpoint.h"
#include "server/core/sheet/contact_bridge.h"
#include "server/core/sheet/rest_watch.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/stage_observer.h"
#include "server/core/sheet/topology.h"
#include "server/core/sheet/undo_history.h"

namespace kerf::sheet {

// The state that a Reset restores.
struct InitialState {
  BuiltMesh built;
  std::shared_ptr<const SheetMaterials> materials;
  std::optional<fem::Softening> softening;
  Eigen::Matrix3Xd velocities;  // 3 x V, m/s
  std::vector<mesh::VertexId> pinned;
  HeldVertices held_vertices;
  AppliedForces applied_forces;
};

// An integrator that is copied by making a new one of the same kind, to be rebuilt before its first step. Nothing is
// lost: integrators keep no history.
class OwnedIntegrator {
 public:
  OwnedIntegrator(IntegratorFactory make, const fem::IntegratorOptions& options)
      : make_(std::move(make)), options_(options), integrator_(make_(options)) {}
  OwnedIntegrator(const OwnedIntegrator& other) : OwnedIntegrator(other.make_, other.options_) {}
  OwnedIntegrator& operator=(const OwnedIntegrator& other) = delete;
  OwnedIntegrator(OwnedIntegrator&&) noexcept = default;
  OwnedIntegrator& operator=(OwnedIntegrator&&) noexcept = default;
  ~OwnedIntegrator() = default;

  fem::Integrator* operator->() const { return integrator_.get(); }

 private:
  IntegratorFactory make_;
  fem::IntegratorOptions options_;
  std::unique_ptr<fem::Integrator> integrator_;
};

// Notifies an observer, if there is one, of the beginning and the end of a stage.
class StageScope {
 public:
  StageScope(StageObserver* observer, Stage stage, std::int32_t command)
      : observer_(observer), stage_(stage), command_(command) {
    if (observer_ != nullptr) observer_->begin(stage_, command_);
  }
  ~StageScope() {
    if (observer_ != nullptr) observer_->end(stage_, command_);
  }
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;

 private:
  StageObserver* observer_;
  Stage stage_;
  std::int32_t command_;
};

// Origin of a command: the observer of its stages, and its number there.
struct CommandContext {
  StageObserver* observer = nullptr;
  std::int32_t index = -1;
};

// kInvalidArgument SHEET_TOO_STIFF for a sheet that is to move, and that double precision cannot move. `prefix`: path
// of the material ("material").
Status check_condition(const SheetConfig& config, const fem::Model& model, const std::string& prefix);

// Chooses for the uncut mesh how the membrane is softened; empty where the scene is exact or not stepped in time.
std::optional<fem::Softening> choose_softening(const SheetConfig& config, const mesh::TriangleMesh& uncut,
                                               const std::vector<fem::Material>& by_region);

// The model that steps a sheet of these materials.
fem::Model make_model(const SheetConfig& config, const mesh::TriangleMesh& mesh,
                      const std::vector<fem::Material>& by_region, const std::optional<fem::Softening>& softening);

// Makes `holds` pin the vertices at their positions in `state`, and sets their velocities to zero.
void hold(const std::vector<mesh::VertexId>& vertices, fem::State& state, std::vector<fem::Pin>& holds);

struct Sheet::Impl {
  Impl(std::shared_ptr<const SheetConfig> sheet_config, std::shared_ptr<const InitialState> initial_state,
       IntegratorFactory make_integrator);

  TickReport run(std::span<const Command> commands, StageObserver* observer, bool advance, const fem::GoesOn* goes_on,
                 const fem::GoesOn* may_go_on);

  // Stages of a tick (sheet.cc).
  void drain_commands(std::span<const Command> commands, StageObserver* observer, bool scheduled, TickReport& report);
  // Does the scene's commands that are due; `number` counts the tick's commands.
  void drain_schedule(StageObserver* observer, std::int32_t& number, TickReport& report);
  void set_loads();
  void stamp(TickReport& report) const;
  void integrate(const fem::GoesOn* goes_on, const fem::GoesOn* may_go_on, TickReport& report);
  // Returns false if the integrator ran out of memory or was interrupted; its own state is invalid then.
  bool step_in_time(const fem::GoesOn* may_go_on, fem::StepStats& stats);
  void watch_rest();
  // Keeps the counts of a step that did not fail. contact_blocks: in all its substeps.
  void count_tick(const fem::StepStats& stats, std::int64_t contact_blocks);
  // Returns the counts of the last tick since the scene began, or those expected of the first.
  [[nodiscard]] fem::TickCounts counts() const;
  // Returns true if the sheet is not frozen and nothing new acts on it: no grab, no change of loads, no command to
  // come.
  [[nodiscard]] bool is_left_alone() const;

  // Constraints and loads (sheet_conditions.cc).
  // Sets constraints, loads and slopes for a step of dt (s, 0: at once) that ends at `end`. Does nothing if none
  // changed.
  void set_conditions(const Instant& end, double dt);
  void follow_conditions(std::span<const mesh::MeshEdit* const> edits);
  void set_slopes(const Instant& at);
  fem::EquilibriumStats settle(double load, const fem::EquilibriumOptions& options,
                               const fem::EquilibriumSolver::Watch& watch);
  TickReport begin_load_step();

  // Commands (sheet_commands.cc). Each changes everything it should, or nothing.
  Result<CommandReply> do_command(const Command& command, const CommandContext& context);
  [[nodiscard]] CommandReply plain_reply() const;  // of a command that answers nothing of its own
  Status grab(const Grab& grab);
  Status drag(const Drag& drag);
  Status release(const Release& release);
  Status set_pins(const SetPins& pins);
  void set_gravity(const Eigen::Vector3d& value);
  void set_wind(const Wind& value);
  Status set_material(const SetMaterial& change);  // sheet_change_material.cc

  // Resets (sheet_reset.cc).
  [[nodiscard]] Checkpoint checkpoint() const;
  [[nodiscard]] Checkpoint initial_checkpoint() const;
  void restore(const Checkpoint& to);
  void reset(const Reset& reset);
  void redo_reset(const UndoStep& step);

  [[nodiscard]] cut::CutRequest request_of(const Cut& cut) const;  // without the fixed vertices
  // mass_before: mass of the sheet before the cut (kg); used only when it has several materials.
  [[nodiscard]] CutReply reply_of(const cut::CutOutcome& outcome, const Cut& cut, double mass_before) const;
  [[nodiscard]] double rest_mass() const;  // kg, of the mesh; O(slots)
  [[nodiscard]] bool has_one_material() const { return materials->by_region.size() == 1; }

  // Cuts (sheet_cuts.cc), whole or not at all like the others.
  Result<CommandReply> cut(const Cut& cut, const CommandContext& context);
  Result<CommandReply> cut_batch(const CutBatch& batch, const CommandContext& context);
  Result<CommandReply> undo_cut(const CommandContext& context);
  Result<CommandReply> redo_cut(const CommandContext& context);
  Result<std::vector<CutReply>> do_cuts(std::span<const Cut> cuts, bool is_batch, const CommandContext& context);
  // Cuts the mesh and nothing else; if a cut is refused, the mesh is as it was. Appends the applied cuts to `done`.
  Result<std::vector<CutReply>> cut_mesh(std::span<const Cut> cuts, bool is_batch, std::vector<DoneCut>& done,
                                         PhaseObserver* observer);
  void follow(const std::vector<DoneCut>& cuts, PhaseObserver* observer);
  void take_back(const std::vector<DoneCut>& cuts, const CommandContext& context);
  // Returns the pins of vertices that the edit leaves without material.
  [[nodiscard]] std::vector<fem::Pin> pins_lost_by(const mesh::MeshEdit& edit) const;
  void finish_edit(std::vector<mesh::VertexId> now_pinned, std::span<const mesh::MeshEdit* const> edits,
                   PhaseObserver* observer);
  [[nodiscard]] CommandReply undo_reply(const UndoStep& step) const;

  void pin(std::vector<mesh::VertexId> vertices);
  void rebuild();
  void make_room();
  [[nodiscard]] std::vector<GrabState>::iterator find_grab(const std::string& grab_id);
  // N/m, of a grab at a vertex.
  [[nodiscard]] double default_stiffness(mesh::VertexId vertex) const;

  void add_shape_to(StateHash& hash) const;

  // Settings: never change.
  std::shared_ptr<const SheetConfig> config;
  std::shared_ptr<const InitialState> initial;
  std::vector<std::size_t> schedule;  // config->commands by tick, equal ticks in their order
  double dt;                          // s

  // State: what a step changes, and what decides the next one.
  mesh::TriangleMesh mesh;
  fem::State state;
  std::vector<mesh::VertexId> pinned;  // sorted, unique
  std::int32_t pins_version = 0;       // those of which SetPins; 0: the scene's
  std::vector<GrabState> grabs;
  std::shared_ptr<const SheetMaterials> materials;  // in force
  std::optional<fem::Softening> softening;          // of these, in the model alone
  Wind wind;
  std::vector<fem::Pin> holds;  // of the vertices in `pinned`, in order
  HeldVertices held_vertices;
  AppliedForces applied_forces;
  Eigen::Vector3d full_gravity;         // m/s^2, at factor 1
  Instant now;                          // when the conditions were set last
  std::vector<mesh::VertexId> clamped;  // whose slope the model holds; sorted
  bool conditions_changed = true;       // since then, other than by time
  fem::Loads loads;                     // pins, and over them the vertices held by constraints; its grabs are set again
                                        // each tick
  std::int64_t tick = 0;
  std::int64_t start_tick = 0;  // from which the scene's clock and histories count
  std::int64_t beginning = 0;   // see CommandReply
  SchedulePlace schedule_place;
  std::int32_t failed_steps = 0;  // in a row
  bool frozen = false;
  UndoHistory history;
  Lineage lineage;
  RestWatch rest;
  std::optional<fem::TickCounts> last_counts;

  // Counters.
  std::int32_t topology_version = 1;
  std::int32_t settings_version = 0;
  std::int32_t last_pins_version = 0;
  std::int64_t last_beginning = 0;
  std::int64_t num_cuts = 0;  // applied, those made again included
  std::int64_t last_cut_number = 0;

  // Derived from settings and state.
  fem::Model model;
  OwnedIntegrator integrator;
  std::string integrator_description;
  ContactBridge contact;
  LazyTopology topology;
  std::vector<mesh::VertexId> removed;  // vertices without material; sorted

  // Scratch of a step.
  fem::State last_good;
};

}  // namespace kerf::sheet
