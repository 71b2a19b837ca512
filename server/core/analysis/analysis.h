#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"

namespace kerf::sheet {
class StageObserver;
}  // namespace kerf::sheet

// Analyses of a scene: steps in time, equilibria and vibrations, with measurements over time or load.
namespace kerf::analysis {

struct Table {
  std::string name;                       // "probes" or "modes"
  std::vector<std::string> columns;       // the first is "time_s", "load" or "mode"
  std::vector<std::vector<double>> rows;  // rows with one number per column
};

struct Progress {
  double done = 0.0;  // -, finished fraction of the work, 0..1
  std::string what;   // for people, such as "tick 12 of 600" or "load 0.25, residual 3e-5"
};

// Receives the progress of an analysis, and returns false to end it early. Called often: once per substep within a
// tick.
using Watch = std::function<bool(const Progress&)>;

struct StaticStats {
  double load = 0.0;                       // -, last load with an equilibrium; the last requested one if `converged` is
                                           // true
  bool converged = true;                   // true if an equilibrium was found at every requested load
  double residual = 0.0;                   // -, fem::EquilibriumStats::residual at `load`
  std::int64_t iterations = 0;             // all Newton steps, including those of failed attempts
  std::int64_t solves = 0;                 // loads at which an equilibrium was searched, including those between
                                           // requested loads
  bool is_stable = true;                   // true if the stiffness at `load` is positive definite, up to rounding
  std::string reason = {};                 // for people: why it did not converge, if known
  std::vector<std::string> left_out = {};  // names of parts of the scene that had no effect: "wind", "colliders",
                                           // "self_contact", "grabs"
};

struct DynamicStats {
  std::int64_t ticks = 0;           // ticks made
  double simulated = 0.0;           // s, simulated time
  fem::FlagCounts flagged_ticks{};  // number of ticks with each flag
};

struct Outcome {
  std::vector<Table> tables;
  std::optional<DynamicStats> dynamics;          // for a dynamic analysis
  std::optional<StaticStats> statics;            // for a static analysis, also for that in ModalAnalysis::about
  std::vector<sheet::ScheduledReply> scheduled;  // replies to the scheduled commands that were done, in order
  bool stopped = false;                          // true if `watch` ended the analysis
};

// Steps the sheet in time by `analysis.ticks`, which may be any number; the table of probes begins at time 0. `after`:
// called with each report, may be empty. Ends early if the sheet freezes.
Result<Outcome> run_dynamic(sheet::Sheet& sheet, const scene::DynamicAnalysis& analysis,
                            const std::vector<scene::Probe>& probes, const Watch& watch,
                            const std::function<void(const sheet::TickReport&)>& after, sheet::StageObserver* observer);

// Run the other analyses. Errors of all three: those of Probes::create(), and the error of a scheduled command that is
// refused, with its path ("commands[2].command.cut.curve"). run_modes() also: kInvalidArgument TOO_MANY_MODES;
// kInternal MODES_NOT_CONVERGED.
Result<Outcome> run_static(sheet::Sheet& sheet, const scene::StaticAnalysis& analysis,
                           const std::vector<scene::Probe>& probes, const Watch& watch);
Result<Outcome> run_modes(sheet::Sheet& sheet, const scene::ModalAnalysis& analysis,
                          const std::vector<scene::Probe>& probes, const Watch& watch);

}  // namespace kerf::analysis
