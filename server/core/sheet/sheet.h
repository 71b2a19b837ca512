#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/fem/step/step_stats.h"
#include "server/core/mesh/ids.h"
#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/snapshot.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

// Types that only some users of a sheet need; they include the headers that define them.
namespace kerf::fem {
class Integrator;
class Model;
struct EquilibriumOptions;
struct EquilibriumStats;
struct IntegratorOptions;
struct Loads;
struct Softening;
struct State;
struct TickCost;
}  // namespace kerf::fem
namespace kerf::mesh {
class TriangleMesh;
}  // namespace kerf::mesh

namespace kerf::scene {
struct SheetMaterials;
}  // namespace kerf::scene

namespace kerf::sheet {

class StageObserver;
class UndoHistory;
struct UnheldPiece;

// The reply to a command of SheetConfig::commands.
struct ScheduledReply {
  std::size_t index = 0;  // index into SheetConfig::commands
  Result<scene::CommandReply> reply;
};

// The report of one step() or apply(). Failures and loss of quality are values here: nothing is thrown or logged.
struct TickReport {
  std::int64_t tick = 0;                             // tick after the step
  std::vector<Result<scene::CommandReply>> replies;  // one for each given command, in order
  std::vector<ScheduledReply> scheduled;             // replies to scheduled commands that were due, in order
  std::size_t num_scheduled_first = 0;               // number of entries of `scheduled` that were done before the given
                                                     // commands
  fem::StepStats stats;      // of the integrator; if time did not advance, only `interrupted` has a meaning
  bool advanced = false;     // true if the tick was counted up
  bool gave_up = false;      // out of memory, or stopped by `give_up`: the sheet is frozen and did not advance
  bool step_failed = false;  // the integrator found no result: positions and velocities are those before the tick
  bool frozen = false;       // see Sheet::frozen()
  bool at_rest = false;      // see Sheet::at_rest()
  bool topology_changed = false;
};

// Energies of the whole sheet.
struct Energies {
  double kinetic = 0.0;   // J
  double membrane = 0.0;  // J
  double bending = 0.0;   // J, including the energy of edge moments, see fem::edge_moment_energy
  double gravity = 0.0;   // J, zero at z = 0 for gravity along -z: -sum m g . x
  [[nodiscard]] double total() const { return kinetic + membrane + bending + gravity; }
};

// A point held by a Grab.
struct GrabState {
  std::string grab_id;
  std::array<mesh::VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};
  Eigen::Vector3d weights{1.0, 0.0, 0.0};          // -, >= 0, sum 1
  std::optional<Eigen::Vector2d> material;         // m, material coordinates of the held point; empty if vertex
                                                   // vertices[0] itself is held
  Eigen::Vector3d target{0.0, 0.0, 0.0};           // m, world
  Eigen::Vector3d previous_target{0.0, 0.0, 0.0};  // m, target at the last tick, from which it moves to `target`
  double stiffness = 0.0;                          // N/m, given or computed
  bool is_default = false;                         // true if the stiffness is computed from the material, since none
                                                   // was given
};

// Makes the integrator of a sheet; each copy of a sheet makes its own. The integrator must keep the promises of
// fem::Integrator, above all that a step depends only on its arguments.
using IntegratorFactory = std::function<std::unique_ptr<fem::Integrator>(const fem::IntegratorOptions&)>;

// One simulated sheet: mesh, material, state, pins, grabs, colliders. Sheets are independent of each other.
//
// The result of step() depends only on the sheet and the commands: it has one thread and no clock, I/O, logging or
// randomness. The same binary gives the same bits for the same config and commands, and so does a copy of a sheet. Not
// thread-safe: the owner must make one call at a time.
class Sheet {
 public:
  // Failed steps in a row after which a sheet is frozen.
  static constexpr std::int32_t kMaxFailedSteps = 3;

  // Checks the whole config and builds the sheet at tick 0.
  // Errors: kInvalidArgument with the field of kerf.v1.Scene ("pins[1].vertices.vertices[0]"); kResourceExhausted
  // TOO_MANY_VERTICES (more than SheetConfig::max_vertices), SOLVER_TOO_DENSE.
  static Result<Sheet> create(scene::SheetConfig config);  // with fem::make_integrator
  static Result<Sheet> create(scene::SheetConfig config, IntegratorFactory make_integrator);

  // Makes a sheet that continues as the one that save() wrote, bit for bit. `config`: that of the saved sheet. `saved`:
  // all that save() wrote; only that may be given, as what is behind right checksums is not checked further. Errors:
  // kDataLoss SAVED_SHEET_DAMAGED; kInvalidArgument SAVED_SHEET_FORMAT (no saved sheet, or of a newer version);
  // kFailedPrecondition SAVED_SHEET_OF_ANOTHER_SCENE, SAVED_SHEET_OF_ANOTHER_BUILD (it would not continue alike); those
  // of create().
  static Result<Sheet> load(scene::SheetConfig config, std::string_view saved);
  static Result<Sheet> load(scene::SheetConfig config, std::string_view saved, IntegratorFactory make_integrator);

  Sheet(const Sheet& other);
  Sheet& operator=(const Sheet& other);
  Sheet(Sheet&&) noexcept;
  Sheet& operator=(Sheet&&) noexcept;
  ~Sheet();

  // Advances by one tick of dt() seconds. Does the scheduled commands that are due, then `commands`, each with all
  // updates that it needs. Then sets the loads, integrates with contact and counts the tick up. A command that fails
  // has its error in the report and changes nothing. A tick without commands allocates no memory. A frozen sheet only
  // does the commands in `commands`.
  // `stop`, if given, can end the integration early (see fem::Integrator::set_stop_condition), except in a tick with
  // scheduled commands. The report then has stats.interrupted, and the state is that after apply(commands). `give_up`,
  // if given, can end the integration at any point, as can a lack of memory. In both cases the sheet is frozen in the
  // state before the integration; see TickReport::gave_up.
  TickReport step(std::span<const scene::Command> commands, StageObserver* observer = nullptr,
                  const std::function<bool()>* stop = nullptr, const std::function<bool()>* give_up = nullptr);

  // Brings the sheet into equilibrium, at rest, under `load` (-, 0..1). Loads and constraints without a history are
  // scaled by `load`; histories take it as their time. Gravity without a history acts in full. The search starts from
  // the current state, which does not change if no equilibrium is found. Time does not advance; wind, contact and grabs
  // have no effect. `watch`: see fem::EquilibriumSolver. The model then bends by angles, see bend_by_angles().
  fem::EquilibriumStats settle(double load, const fem::EquilibriumOptions& options,
                               const std::function<bool(const fem::EquilibriumStats&)>& watch);
  // Makes the model bend by angles (see fem::AngleBending), which equilibria and vibrations need and steps in time do
  // not. This lasts until the next step, or until the mesh or the clamped vertices change.
  void bend_by_angles();
  // Finds a piece that has no equilibrium under this load, since nothing holds it against a force; settle() would not
  // converge. Returns nothing if there is no such piece.
  std::optional<UnheldPiece> find_unheld(double load);
  // Does the scheduled commands that are due and counts the tick up, without a step in time: for a load of a static
  // analysis.
  TickReport begin_load_step();

  // Does commands without advancing time, for example in a paused sheet. Scheduled commands keep waiting.
  TickReport apply(std::span<const scene::Command> commands, StageObserver* observer = nullptr);

  [[nodiscard]] const scene::SheetConfig& config() const;  // as given
  [[nodiscard]] std::shared_ptr<const scene::SheetConfig> shared_config() const;
  [[nodiscard]] const std::vector<scene::ComponentPlace>& components() const;  // by index into config().components
  [[nodiscard]] const std::vector<std::string>& mesh_notes() const;            // of readers of mesh files, for people
  [[nodiscard]] std::int64_t tick() const;                                     // ticks made since the sheet was created
  [[nodiscard]] std::int64_t scene_tick() const;        // ticks made since the scene began or was reset
  [[nodiscard]] double dt() const;                      // s
  [[nodiscard]] std::int32_t topology_version() const;  // 1 at first, grows by 1 with each applied cut or batch, undo,
                                                        // redo and reset
  [[nodiscard]] std::int32_t settings_version() const;  // grows by 1 with each change of pins, gravity, wind,
                                                        // material or self-contact
  [[nodiscard]] const mesh::TriangleMesh& mesh() const;
  [[nodiscard]] const fem::Model& model() const;  // of mesh() and materials(), with softening()
  [[nodiscard]] const fem::State& state() const;  // x: 3 x V, m; v: 3 x V, m/s
  [[nodiscard]] const fem::Loads& loads() const;  // loads of the last step, or of settle()
  // Returns the initial position in the world (m) of a point in material coordinates (m). A point outside the sheet as
  // built is replaced by the nearest point of the sheet.
  [[nodiscard]] Eigen::Vector3d start_of(const Eigen::Vector2d& material) const;
  [[nodiscard]] const Eigen::Vector3d& gravity() const;                      // m/s^2, as set at present, without
                                                                             // gravity_history
  [[nodiscard]] const std::optional<fem::Softening>& softening() const;      // as chosen at present, for
                                                                             // Fidelity::kRealTime
  [[nodiscard]] const scene::Wind& wind() const;                             // as set at present
  [[nodiscard]] const scene::SheetMaterials& materials() const;              // as set at present
  [[nodiscard]] const scene::SelfContact& self_contact() const;              // as set at present
  [[nodiscard]] const std::vector<mesh::VertexId>& pinned_vertices() const;  // sorted, unique
  [[nodiscard]] const std::vector<GrabState>& grabs() const;                 // in the order in which they were made
  [[nodiscard]] std::int64_t contact_phases() const;                         // substeps in which colliders were checked
  [[nodiscard]] std::int64_t num_cuts() const;                      // cuts applied since creation; a redo counts again
  [[nodiscard]] const UndoHistory& history() const;                 // steps that can be undone and redone
  [[nodiscard]] std::vector<scene::Piece> pieces() const;           // at present, by label. O(slots)
  [[nodiscard]] const std::string& integrator_description() const;  // which integrator runs, and why
  // Returns statistics of the clusters of vertices around tiny triangles, and of the substeps of a tick. Returns
  // nothing if there are no clusters.
  [[nodiscard]] std::optional<fem::LocalInertiaStats> local_inertia() const;
  // Returns the expected cost of the next tick, see fem::TickCost; 0 ns if the integrator gives no estimate.
  [[nodiscard]] fem::TickCost expected_cost() const;
  [[nodiscard]] Energies energies() const;

  // Returns true if the sheet is at rest: no vertex is expected to move by 0.1 mm within a minute, see RestWatch. There
  // must also be no grab, no change of loads to come, and no scheduled command to come. The owner decides whether such
  // a sheet sleeps.
  [[nodiscard]] bool at_rest() const;

  // Returns true if kMaxFailedSteps steps failed in a row, or a step gave up (TickReport::gave_up). The state is that
  // of the last good tick. A frozen sheet can be read and cut; it advances again only after a Reset.
  [[nodiscard]] bool frozen() const;

  // Hashes the bits of mesh, positions, velocities, held vertices, grabs, gravity, wind and tick. Materials and
  // settings of self-contact are included if they are not those of the config.
  [[nodiscard]] std::uint64_t state_hash() const;

  // Hashes the same without the tick, so that it has its first value again after a Reset.
  [[nodiscard]] std::uint64_t shape_hash() const;

  // Hashes everything that decides the future of the sheet: besides the above also its history for undo and redo,
  // pieces, versions, numbers, place in the schedule, failed steps and rest. Two sheets of one scene with equal hashes
  // reply and move alike from now on. O(state + history).
  [[nodiscard]] std::uint64_t continuation_hash() const;
  // Writes the same to `sink`, in one call a section, see saved_sheet.h. Takes about 200 bytes a vertex, and at most
  // 32 MiB of history. Call it between two ticks.
  void save(const std::function<void(std::string_view)>& sink) const;

  // Returns the state that viewers get. Snapshot::topology is made again only if the topology has changed.
  [[nodiscard]] std::shared_ptr<Snapshot> snapshot(const RunStats& stats = {}, bool with_strains = false) const;

 private:
  friend struct Fields<Sheet>;
  struct Impl;
  explicit Sheet(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::sheet
