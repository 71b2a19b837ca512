#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"

// Sheets of the thesis in motion: wool of its table 4.1, 1 m x 1 m, 0.5 mm, held by its two upper corners, let go from
// the horizontal, in ticks of 1/60 s. The thesis gives the material; the rest is assumed.
namespace kerf::evaluation {

// Ways to cut and to step.
struct Way {
  std::string name;
  cut::CutOptions cut;
  bool is_one_solve = false;  // implicit Euler with one solve by plain conjugate gradients, as the thesis has it
};
Way no_optimisation();  // the thesis's method of cutting without its bisection
Way thesis();
Way kerf_default();

scene::SheetConfig wool_sheet(int side);
sheet::Sheet make_sheet(const scene::SheetConfig& config, const Way& way);

// Times of ticks in which commands were done, and after them.
struct TickTimes {
  double before_ms = 0.0, during_ms = 0.0;      // CPU time of a tick; before: mean
  double after_ms = 0.0, after_worst_ms = 0.0;  // mean and worst
  std::map<std::string, double> stages_ms;      // of the tick with the cut: cut, update, step
  double linear_residual = 0.0;                 // -, the worst of these ticks, see fem::StepStats
  int unconverged = 0;                          // ticks whose solves ended above the tolerance
  int linear_iterations = 0;                    // of the tick with the cut
};

// Steps `sheet` through some ticks, one with `commands`, and some more.
TickTimes time_ticks(sheet::Sheet& sheet, int ticks_before, const std::vector<scene::Command>& commands,
                     int ticks_after);

// A cut to make, by any way.
struct GivenCut {
  GivenCut(cut::Curve along, std::optional<cut::Fit> into = std::nullopt)  // NOLINT(google-explicit-constructor)
      : curve(std::move(along)), fit(std::move(into)) {}

  cut::Curve curve;
  std::optional<cut::Fit> fit;
};

// Returns the options with which `way` makes a cut.
cut::CutOptions options_of(const GivenCut& cut, const Way& way);
std::vector<scene::Command> commands_of(const std::vector<GivenCut>& cuts, const Way& way);

// One solve of the first implicit step after a cut, to a relative residual of 1e-6.
struct Solve {
  std::string solver;
  double ms = 0.0;  // median of 3, or the first if it takes more than a second
  int iterations = 0;
  double residual = 0.0;  // -, |b - A x| / |b| with the true A
  double error = 0.0;     // -, |x - x_direct| / |x_direct|
};
Solve time_solve(const sheet::Sheet& sheet, linear::LinearSolverKind kind, const linear::CovarianceRootOptions& root,
                 const std::string& name);

}  // namespace kerf::evaluation
