#include "server/core/analysis/analysis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <utility>

#include "server/core/analysis/probe.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/fem/statics/equilibrium_options.h"
#include "server/core/fem/statics/modes.h"
#include "server/core/sheet/unheld.h"

namespace kerf::analysis {

namespace {

// Smallest load step, over the distance between two requested loads. If even this step fails, the analysis ends.  -
constexpr double kSmallestStep = 1.0 / 4096.0;

std::string text(const char* format, double a, double b) {
  std::array<char, 96> line{};
  std::snprintf(line.data(), line.size(), format, a, b);
  return line.data();
}

Table table_of(const Probes& probes, const std::string& first) {
  Table table{"probes", {first}, {}};
  table.columns.insert(table.columns.end(), probes.columns().begin(), probes.columns().end());
  return table;
}

// Appends the replies to `kept`. Returns the error of the first reply that is an error.
Status keep(std::vector<sheet::ScheduledReply> scheduled, std::vector<sheet::ScheduledReply>& kept) {
  for (sheet::ScheduledReply& answer : scheduled) {
    if (!answer.reply.ok()) {
      Error error = answer.reply.error();
      error.message = "scheduled command " + std::to_string(answer.index) + ": " + error.message;
      const std::string path = "commands[" + std::to_string(answer.index) + "].command";
      error.field = error.field.empty() ? path : path + "." + error.field;
      return error;
    }
    kept.push_back(std::move(answer));
  }
  return Nothing{};
}

std::string describe(const sheet::UnheldPiece& unheld, std::int32_t num_pieces) {
  const std::string what =
      num_pieces == 1 ? "the sheet"
                      : text("the piece at material point (%.4g, %.4g)", unheld.material.x(), unheld.material.y());
  std::array<char, 240> line{};
  std::snprintf(
      line.data(), line.size(),
      "nothing holds %s along %c, where gravity and loads on it add up to %.4g N: hold it by a constraint or a "
      "pin, or balance the loads",
      what.c_str(), "xyz"[unheld.component], unheld.force);
  return line.data();
}

// Lists the parts of the scene that a static analysis leaves out.
std::vector<std::string> left_out_of(const sheet::Sheet& sheet) {
  std::vector<std::string> names;
  if (sheet.wind().air_density > 0.0 && !sheet.wind().velocity.isZero(0.0)) names.emplace_back("wind");
  if (!sheet.config().colliders.empty()) names.emplace_back("colliders");
  if (sheet.self_contact().is_on) names.emplace_back("self_contact");
  if (!sheet.grabs().empty()) names.emplace_back("grabs");
  return names;
}

// Leads a sheet from one requested load to the next, in smaller steps if necessary. advance() returns false if the load
// was not reached, or `watch` ended the work.
class LoadPath {
 public:
  LoadPath(sheet::Sheet& sheet, const scene::StaticAnalysis& analysis, const Watch& watch, StaticStats& stats)
      : sheet_(sheet), watch_(watch), stats_(stats) {
    options_.tolerance = analysis.tolerance;
    options_.max_iterations = analysis.max_iterations;
  }

  bool advance(double to) {
    const double from = stats_.load;
    double step = to - from;
    while (stats_.load < to && !stopped_) {
      // The last step ends exactly at `to`.
      const double target = stats_.load + 1.0001 * step >= to ? to : stats_.load + step;
      if (solve(target)) {
        step *= 2.0;
        continue;
      }
      step *= 0.5;
      if (step < kSmallestStep * (to - from)) return false;
    }
    return !stopped_;
  }
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  bool solve(double load) {
    const auto report = [&](const fem::EquilibriumStats& stats) {
      if (watch_ && !watch_({stats_.load, text("load %.4g, residual %.1e", load, stats.residual)})) stopped_ = true;
      return !stopped_;
    };
    if (const std::optional<sheet::UnheldPiece> unheld = sheet_.find_unheld(load)) {
      stats_.reason = describe(*unheld, sheet_.mesh().num_pieces());
      return false;
    }
    stats_.reason.clear();
    const fem::EquilibriumStats found = sheet_.settle(load, options_, report);
    ++stats_.solves;
    stats_.iterations += found.iterations;
    if (!found.converged) return false;
    stats_.load = load;
    stats_.residual = found.residual;
    stats_.is_stable = found.shift == 0.0;
    return true;
  }

  sheet::Sheet& sheet_;
  const Watch& watch_;
  StaticStats& stats_;
  fem::EquilibriumOptions options_;
  bool stopped_ = false;
};

}  // namespace

Result<Outcome> run_dynamic(sheet::Sheet& sheet, const scene::DynamicAnalysis& analysis,
                            const std::vector<scene::Probe>& requests, const Watch& watch,
                            const std::function<void(const sheet::TickReport&)>& after,
                            sheet::StageObserver* observer) {
  KERF_TRY_ASSIGN(Probes probes, Probes::create(requests, sheet));
  const bool measures = !probes.columns().empty();
  Outcome outcome;
  DynamicStats stats;
  Table table = table_of(probes, "time_s");
  const auto measure = [&](const linear::VertexField& v_before, double dt) {
    std::vector<double> row{stats.simulated};
    probes.measure(sheet, v_before, dt, row);
    table.rows.push_back(std::move(row));
  };
  if (measures) measure({}, 0.0);
  linear::VertexField v_before;
  Progress progress{0.0, "tick 0 of " + std::to_string(analysis.ticks)};
  const StopCondition stop = [&] {
    outcome.stopped = outcome.stopped || (watch && !watch(progress));
    return outcome.stopped;
  };
  for (std::int64_t i = 1; i <= analysis.ticks && !sheet.frozen() && !outcome.stopped; ++i) {
    const bool measures_now = measures && (i % analysis.measure_every == 0 || i == analysis.ticks);
    const std::int32_t version = sheet.topology_version();
    if (measures_now) v_before = sheet.state().v;
    sheet::TickReport report = sheet.step({}, observer, &stop);
    if (report.stats.interrupted) break;
    if (after) after(report);
    KERF_TRY(keep(std::move(report.scheduled), outcome.scheduled));
    ++stats.ticks;
    stats.simulated += report.stats.simulated;
    fem::count_flags(report.stats.flags, stats.flagged_ticks);
    // If the vertices changed in this tick, the old velocities give no accelerations.
    const bool is_same = version == sheet.topology_version();
    if (measures_now) measure(v_before, is_same ? report.stats.simulated : 0.0);
    progress = {static_cast<double>(i) / static_cast<double>(analysis.ticks),
                "tick " + std::to_string(i) + " of " + std::to_string(analysis.ticks)};
    static_cast<void>(stop());
  }
  outcome.dynamics = stats;
  if (measures) outcome.tables.push_back(std::move(table));
  return outcome;
}

Result<Outcome> run_static(sheet::Sheet& sheet, const scene::StaticAnalysis& analysis,
                           const std::vector<scene::Probe>& requests, const Watch& watch) {
  KERF_TRY_ASSIGN(Probes probes, Probes::create(requests, sheet));
  Outcome outcome;
  StaticStats stats;
  Table table = table_of(probes, "load");
  LoadPath path(sheet, analysis, watch, stats);
  for (const double load : analysis.loads) {
    sheet::TickReport report = sheet.begin_load_step();
    KERF_TRY(keep(std::move(report.scheduled), outcome.scheduled));
    if (!path.advance(load)) {
      stats.converged = false;
      break;
    }
    std::vector<double> row{load};
    probes.measure(sheet, {}, 0.0, row);
    table.rows.push_back(std::move(row));
  }
  outcome.stopped = path.stopped();
  if (stats.converged) stats.reason.clear();
  stats.left_out = left_out_of(sheet);
  outcome.statics = stats;
  if (!probes.columns().empty()) outcome.tables.push_back(std::move(table));
  return outcome;
}

Result<Outcome> run_modes(sheet::Sheet& sheet, const scene::ModalAnalysis& analysis,
                          const std::vector<scene::Probe>& probes, const Watch& watch) {
  Outcome outcome;
  const bool is_live = !analysis.about && sheet.tick() > 0;
  if (analysis.about) {
    KERF_TRY_ASSIGN(outcome, run_static(sheet, *analysis.about, probes, watch));
    if (outcome.stopped || !outcome.statics->converged) return outcome;
  } else if (!is_live) {
    // A sheet that runs is analysed as it is. For a scene that has not begun, its first commands, such as cuts, are
    // done before.
    sheet::TickReport report = sheet.begin_load_step();
    KERF_TRY(keep(std::move(report.scheduled), outcome.scheduled));
  }
  if (watch && !watch({0.5, "factorising"})) {
    outcome.stopped = true;
    return outcome;
  }
  const int num_free = fem::num_free_components(sheet.model(), sheet.loads());
  if (analysis.count >= num_free) {
    return invalid_argument("TOO_MANY_MODES",
                            "analysis.modes.count is " + std::to_string(analysis.count) + "; the sheet has " +
                                std::to_string(num_free) + " free components, and as many modes",
                            "analysis.modes.count");
  }
  // A sheet that runs is in balance with the bending forces of steps in time, not with those by angles.
  if (!is_live) sheet.bend_by_angles();
  const fem::Modes modes = fem::find_modes(sheet.model(), sheet.loads(), sheet.state().x, analysis.count, [&watch] {
    return watch && !watch({0.75, "searching"});
  });
  if (modes.stopped) {
    outcome.stopped = true;
    return outcome;
  }
  if (!modes.converged) {
    return internal_error(
        "MODES_NOT_CONVERGED",
        "the lowest vibrations did not converge; request fewer modes, or refine the state that they are about",
        "analysis.modes");
  }
  Table table{"modes", {"mode", "eigenvalue_per_s2", "frequency_hz"}, {}};
  for (Eigen::Index i = 0; i < modes.eigenvalues.size(); ++i) {
    const double value = modes.eigenvalues[i];
    const double frequency = std::copysign(std::sqrt(std::abs(value)), value) / (2.0 * std::numbers::pi);
    table.rows.push_back({static_cast<double>(i + 1), value, frequency});
  }
  outcome.tables.push_back(std::move(table));
  return outcome;
}

}  // namespace kerf::analysis
