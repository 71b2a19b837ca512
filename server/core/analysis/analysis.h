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

// Analyses of a scene: equilibria, vibrations, and measurements over time or load.
namespace kerf::analysis {

struct Table {
  std::string name;                       // "probes" or "modes"
  std::vector<std::string> columns;       // the first is time_s, load or mode
  std::vector<std::vector<double>> rows;  // one number a column
};

struct Progress {
  double done = 0.0;  // -, 0..1
  std::string what;   // for people: "tick 12 of 600", "load 0.25, residual 3e-5"
};

// Returns false to end the work where it is. Called often, in a tick once a substep.
using Watch = std::function<bool(const Progress&)>;

struct StaticStats {
  double load = 0.0;                       // reached; the last one requested, unless `converged` is false
  bool converged = true;                   // at every requested load
  double residual = 0.0;                   // -, at the last load that converged; see fem::EquilibriumStats
  std::int64_t iterations = 0;             // Newton steps in all, those of attempts in vain included
  std::int64_t solves = 0;                 // loads approached, those between included
  bool is_stable = true;                   // the stiffness at the last load is positive definite, up to rounding
  std::string reason = {};                 // why it did not converge, where that is known: for people
  std::vector<std::string> left_out = {};  // of what acts on the sheet: "wind", "colliders", "grabs"
};

struct DynamicStats {
  std::int64_t ticks = 0;           // done
  double simulated = 0.0;           // s
  fem::FlagCounts flagged_ticks{};  // of these
};

struct Outcome {
  std::vector<Table> tables;
  std::optional<DynamicStats> dynamics;          // of a dynamic analysis
  std::optional<StaticStats> statics;            // of a static analysis, or the one that modes are about
  std::vector<sheet::ScheduledReply> scheduled;  // answers of the commands that were done, in order
  bool stopped = false;                          // by `watch`
};

// Steps in time, `analysis.ticks` of any number; its table begins at time 0. `after`: called with each report, may be
// empty. A sheet that freezes is stepped no further.
Result<Outcome> run_dynamic(sheet::Sheet& sheet, const sheet::DynamicAnalysis& analysis,
                            const std::vector<sheet::Probe>& probes, const Watch& watch,
                            const std::function<void(const sheet::TickReport&)>& after, sheet::StageObserver* observer);

// Run the analysis of a sheet. Errors: those of Probes::create, and the error of a scheduled command that is refused,
// with its path ("commands[2].command.cut.curve").
Result<Outcome> run_static(sheet::Sheet& sheet, const sheet::StaticAnalysis& analysis,
                           const std::vector<sheet::Probe>& probes, const Watch& watch);
Result<Outcome> run_modes(sheet::Sheet& sheet, const sheet::ModalAnalysis& analysis,
                          const std::vector<sheet::Probe>& probes, const Watch& watch);

}  // namespace kerf::analysis
