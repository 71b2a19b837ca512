#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/fem/step/step_stats.h"
#include "server/core/mesh/ids.h"
#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/snapshot.h"

// Declares what only some users of a sheet look into; their headers define it.
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

namespace kerf::sheet {

class StageObserver;
class UndoHistory;
struct SheetMaterials;
struct UnheldPiece;

// The answer to a command of SheetConfig::commands.
struct ScheduledReply {
  std::size_t index = 0;  // into SheetConfig::commands
  Result<CommandReply> reply;
};

// Reports one step() or apply(). Degradation is a value here: nothing is thrown or logged.
struct TickReport {
  std::int64_t tick = 0;                      // after it
  std::vector<Result<CommandReply>> replies;  // one for each given command, in order
  std::vector<ScheduledReply> scheduled;      // those that fell due, in order
  std::size_t num_scheduled_first = 0;        // of `scheduled`: those done before the given commands
  fem::StepStats stats;      // of the integrator; default where time did not advance, except `interrupted`
  bool advanced = false;     // ++tick happened
  bool gave_up = false;      // out of memory, or stopped by give_up: frozen and not advanced
  bool step_failed = false;  // the integrator gave up: positions and velocities are those before the tick
  bool frozen = false;       // see Sheet::frozen()
  bool at_rest = false;      // see Sheet::at_rest()
  bool topology_changed = false;
};

// Energies of the whole sheet.
struct Energies {
  double kinetic = 0.0;   // J
  double membrane = 0.0;  // J
  double bending = 0.0;   // J, with what moments store at the border; see fem::edge_moment_energy
  double gravity = 0.0;   // J, zero at z = 0 for gravity along -z: -sum m g . x
  [[nodiscard]] double total() const { return kinetic + membrane + bending + gravity; }
};

// A point held by a Grab.
struct GrabState {
  std::string grab_id;
  std::array<mesh::VertexId, 3> vertices{mesh::kNone, mesh::kNone, mesh::kNone};
  Eigen::Vector3d weights{1.0, 0.0, 0.0};          // -, >= 0, sum 1
  std::optional<Eigen::Vector2d> material;         // m, the point held; empty while vertices[0] itself is held
  Eigen::Vector3d target{0.0, 0.0, 0.0};           // m, world
  Eigen::Vector3d previous_target{0.0, 0.0, 0.0};  // m, target of the last tick; it moves from there to `target`
  double stiffness = 0.0;                          // N/m, given or computed
  bool is_default = false;                         // no stiffness was given; it is computed from the material
};

// Makes what advances a sheet; copies of a sheet each make their own. The integrator must keep fem::Integrator's
// promises, above all that a step depends on its arguments alone.
using IntegratorFactory = std::function<std::unique_ptr<fem::Integrator>(const fem::IntegratorOptions&)>;

// One simulated sheet: mesh, material, state, pins, grabs, colliders. The unit of simulation, ownership and isolation.
//
// step() is a pure function of the sheet and the commands: single-threaded, clock-free, no I/O, no logging, no
// randomness. The same binary given the same config and commands produces the same bits, and so does a copy: copies
// continue with equal hashes. Not thread-safe; the owner serialises.
class Sheet {
 public:
  // After this many failed steps in a row a sheet is frozen.
  static constexpr std::int32_t kMaxFailedSteps = 3;

  // Checks the whole config and builds the sheet at tick 0.
  // Errors: kInvalidArgument with the field of kerf.v1.Scene ("pins[1].vertices.vertices[0]"); kResourceExhausted
  // TOO_MANY_VERTICES, of the config's own limit.
  static Result<Sheet> create(SheetConfig config);  // with fem::make_integrator
  static Result<Sheet> create(SheetConfig config, IntegratorFactory make_integrator);

  Sheet(const Sheet& other);
  Sheet& operator=(const Sheet& other);
  Sheet(Sheet&&) noexcept;
  Sheet& operator=(Sheet&&) noexcept;
  ~Sheet();

  // Advances by one tick of dt() seconds. Drains the scheduled commands that are due, then `commands`, each with its
  // cut and model update; then loads, integration with contact, ++tick. A command that fails has its error in the
  // report and changes nothing. Allocates nothing where there is no command. A frozen sheet does its commands and does
  // not advance.
  // `stop`, if given, can end the integration early (see fem::Integrator::set_stop_condition), except in a tick with
  // scheduled commands. The report then has stats.interrupted, and the state is that after apply(commands). `give_up`
  // can end it at any point, as can a lack of memory. Both also freeze the sheet, with the state before the
  // integration; see gave_up.
  TickReport step(std::span<const Command> commands, StageObserver* observer = nullptr,
                  const std::function<bool()>* stop = nullptr, const std::function<bool()>* give_up = nullptr);

  // Puts the sheet into equilibrium, at rest, under `load` (-, 0..1). Loads and constraints without a history scale
  // with it; histories are read at it. Gravity without a history acts in full. Starts from the current state, which
  // stays as it is if no equilibrium is found. Time does not advance; wind, contact and grabs are left out. `watch`:
  // see fem::EquilibriumSolver. Bends by angles, see bend_by_angles().
  fem::EquilibriumStats settle(double load, const fem::EquilibriumOptions& options,
                               const std::function<bool(const fem::EquilibriumStats&)>& watch);
  // Makes the model bend by angles (see fem::AngleBending), as equilibria and vibrations need and steps in time do not.
  // Lasts until the next step, or until the mesh or the clamped vertices change.
  void bend_by_angles();
  // Finds a piece without any equilibrium under that load, as nothing holds it against a force: settle() would not
  // converge. Nothing if all pieces are held.
  std::optional<UnheldPiece> find_unheld(double load);
  // Does the scheduled commands that are due and ++tick, and nothing else: a step of a static analysis.
  TickReport begin_load_step();

  // Does commands without advancing time: a paused sheet is cut at once. Scheduled commands stay where they are.
  TickReport apply(std::span<const Command> commands, StageObserver* observer = nullptr);

  [[nodiscard]] const SheetConfig& config() const;  // as given
  [[nodiscard]] std::shared_ptr<const SheetConfig> shared_config() const;
  [[nodiscard]] std::int64_t tick() const;              // ticks done
  [[nodiscard]] std::int64_t scene_tick() const;        // ticks done since the scene began or was reset
  [[nodiscard]] double dt() const;                      // s
  [[nodiscard]] std::int32_t topology_version() const;  // 1 at first; + 1 with each applied cut or batch, undo, redo
                                                        // and reset
  [[nodiscard]] std::int32_t settings_version() const;  // + 1 with each change of pins, gravity, wind or material
  [[nodiscard]] const mesh::TriangleMesh& mesh() const;
  [[nodiscard]] const fem::Model& model() const;  // of mesh() and materials(), with softening()
  [[nodiscard]] const fem::State& state() const;  // x: 3 x V, m; v: 3 x V, m/s
  [[nodiscard]] const fem::Loads& loads() const;  // of the last step, or settle()
  // Returns the initial world position (m) of a material point (m). For a point outside the sheet as it was made, it is
  // that of the nearest point of the sheet.
  [[nodiscard]] Eigen::Vector3d start_of(const Eigen::Vector2d& material) const;
  [[nodiscard]] const Eigen::Vector3d& gravity() const;                      // m/s^2, in force
  [[nodiscard]] const std::optional<fem::Softening>& softening() const;      // in force, of Fidelity::kRealTime
  [[nodiscard]] const Wind& wind() const;                                    // in force
  [[nodiscard]] const SheetMaterials& materials() const;                     // in force
  [[nodiscard]] const std::vector<mesh::VertexId>& pinned_vertices() const;  // sorted, unique
  [[nodiscard]] const std::vector<GrabState>& grabs() const;                 // in the order they were made
  [[nodiscard]] std::int64_t contact_phases() const;  // substeps in which colliders were looked at
  [[nodiscard]] std::int64_t num_cuts() const;        // cuts applied since creation, those made again included
  [[nodiscard]] const UndoHistory& history() const;   // what can be undone and redone
  [[nodiscard]] std::vector<Piece> pieces() const;    // as they are, by label. O(slots)
  [[nodiscard]] const std::string& integrator_description() const;  // which one runs and why
  // Returns the clusters that cuts made, and the substeps of a tick; nothing if there are none.
  [[nodiscard]] std::optional<fem::LocalInertiaStats> local_inertia() const;
  // Estimates the cost of a tick of the sheet as it is; see fem::TickCost. 0 ns if the integrator gives no estimate.
  [[nodiscard]] fem::TickCost expected_cost() const;
  [[nodiscard]] Energies energies() const;

  // Returns true if the sheet is at rest: no vertex is expected to move by 0.1 mm within a minute, see RestWatch. Also
  // nothing is to change the forces on it: no grab, no change of loads, no command to come. Putting it to sleep is left
  // to the owner.
  [[nodiscard]] bool at_rest() const;

  // Returns true if kMaxFailedSteps steps failed in a row, or a step gave up (TickReport::gave_up). The state is that
  // of the last good tick; the sheet can be inspected, cut and reset. Only a Reset lets it advance again.
  [[nodiscard]] bool frozen() const;

  // Hashes mesh, positions, velocities, pins, grabs, loads, materials that are not the config's, and tick, bit for bit.
  [[nodiscard]] std::uint64_t state_hash() const;

  // Hashes the same without the tick and the versions: after a Reset it has its first value again.
  [[nodiscard]] std::uint64_t shape_hash() const;

  // Returns the state as viewers get it. The Topology in it is rebuilt only after it changed.
  [[nodiscard]] std::shared_ptr<const Snapshot> snapshot(const RunStats& stats = {}, bool with_strains = false) const;

 private:
  struct Impl;
  explicit Sheet(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::sheet
