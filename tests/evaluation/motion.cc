#include "tests/evaluation/motion.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "server/base/check.h"
#include "server/core/fem/element/material.h"
#include "server/core/linear/linear_solver.h"
#include "server/core/mesh/triangle_mesh.h"
#include "tests/bench/race_one_solve.h"
#include "tests/bench/solver_system.h"
#include "tests/bench/stage_clock.h"

namespace kerf::evaluation {
namespace {

constexpr double kStep = 1.0 / 60.0;  // s

// Returns the CPU time of a tick, ms.
double step(sheet::Sheet& sheet, const std::vector<scene::Command>& commands, TickTimes& times,
            bench::StageClock& clock) {
  const double start = bench::thread_cpu_s();
  const sheet::TickReport report = sheet.step(commands, &clock);
  const double ms = 1e3 * (bench::thread_cpu_s() - start);
  for (const Result<scene::CommandReply>& reply : report.replies) {
    KERF_CHECK(reply.ok(), "a cut of the evaluation is refused");
  }
  times.linear_residual = std::max(times.linear_residual, report.stats.linear_residual);
  times.unconverged += (report.stats.flags & fem::kNotConverged) != 0 ? 1 : 0;
  if (!commands.empty()) times.linear_iterations = report.stats.linear_iterations;
  return ms;
}

}  // namespace

Way no_optimisation() {
  Way way{"no optimisation", {}, true};
  way.cut.method = cut::Method::kElement;
  way.cut.element_limits.edge_ratio = std::numeric_limits<double>::infinity();
  return way;
}

Way thesis() {
  Way way{"thesis", {}, true};
  way.cut.method = cut::Method::kElement;
  return way;
}

Way kerf_default() {
  return {"default", {}, false};
}

scene::SheetConfig wool_sheet(int side) {
  scene::SheetConfig config;
  scene::GridSource grid;
  grid.columns = side;
  grid.rows = side;
  config.mesh = grid;
  config.material = fem::find_preset("wool").value();
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.emplace_back(scene::RegionEdge::kTopCorners);
  return config;
}

sheet::Sheet make_sheet(const scene::SheetConfig& config, const Way& way) {
  const auto one_solve = [](const fem::IntegratorOptions& /*options*/) {
    return bench::make_one_solve(linear::LinearSolverKind::kPlainCg);
  };
  Result<sheet::Sheet> sheet =
      way.is_one_solve ? sheet::Sheet::create(config, one_solve) : sheet::Sheet::create(config);
  KERF_CHECK(sheet.ok(), "a sheet of the evaluation is refused");
  return std::move(sheet).value();
}

TickTimes time_ticks(sheet::Sheet& sheet, int ticks_before, const std::vector<scene::Command>& commands,
                     int ticks_after) {
  TickTimes times;
  for (int i = 0; i < ticks_before; ++i) {
    bench::StageClock clock;
    times.before_ms += step(sheet, {}, times, clock) / ticks_before;
  }
  bench::StageClock clock;
  times.during_ms = step(sheet, commands, times, clock);
  times.stages_ms["cut"] = 1e3 * clock.spent(sheet::Stage::kCut);
  times.stages_ms["update"] = 1e3 * clock.spent(sheet::Stage::kModelUpdate);
  times.stages_ms["step"] = 1e3 * (clock.spent(sheet::Stage::kLoads) + clock.spent(sheet::Stage::kIntegrate));
  for (int i = 0; i < ticks_after; ++i) {
    bench::StageClock unused;
    const double ms = step(sheet, {}, times, unused);
    times.after_ms += ms / ticks_after;
    times.after_worst_ms = std::max(times.after_worst_ms, ms);
  }
  return times;
}

cut::CutOptions options_of(const GivenCut& cut, const Way& way) {
  cut::CutOptions options = way.cut;
  options.fit = cut.fit;
  return options;
}

std::vector<scene::Command> commands_of(const std::vector<GivenCut>& cuts, const Way& way) {
  scene::CutBatch batch;
  for (const GivenCut& each : cuts) {
    scene::Cut& cut = batch.cuts.emplace_back();
    cut.curve = each.curve;
    cut.options = options_of(each, way);
  }
  return {batch};
}

Solve time_solve(const sheet::Sheet& sheet, linear::LinearSolverKind kind, const linear::CovarianceRootOptions& root,
                 const std::string& name) {
  constexpr int kRepeats = 3;
  constexpr int kMaxIterations = 10'000;
  constexpr double kLong = 1000.0;  // ms, of a solve that is not repeated
  constexpr double kTolerance = 1e-6;
  bench::System system = bench::system_at(sheet.model(), sheet.loads(), sheet.state(), kStep);
  const linear::BlockMatrix& a = system.tangent.blocks();
  linear::VertexField exact(sheet.model().num_vertices()), x(sheet.model().num_vertices());
  const auto solve_with = [&](linear::LinearSolver& solver, double tolerance, linear::VertexField& to) {
    if (std::vector<Eigen::Matrix3d>* frames = solver.frames()) *frames = system.frames;
    if (linear::VertexField* positions = solver.positions()) *positions = system.positions;
    to.setZero();
    return solver.solve(a, system.b, tolerance, to);
  };
  const std::unique_ptr<linear::LinearSolver> direct = linear::make_linear_solver(linear::LinearSolverKind::kDirect, 1);
  direct->analyse(a);
  solve_with(*direct, kTolerance, exact);

  Solve result;
  result.solver = name;
  std::vector<double> times;
  const std::unique_ptr<linear::LinearSolver> solver = linear::make_linear_solver(kind, kMaxIterations, root);
  solver->analyse(a);
  for (int i = 0; i < kRepeats; ++i) {
    const double start = bench::thread_cpu_s();
    const linear::LinearStats stats = solve_with(*solver, kTolerance, x);
    times.push_back(1e3 * (bench::thread_cpu_s() - start));
    result.iterations = stats.iterations;
    result.residual = stats.residual;
    if (times.back() > kLong) break;
  }
  std::sort(times.begin(), times.end());
  result.ms = times[times.size() / 2];
  double square = 0.0, of = 0.0;
  for (Eigen::Index v = 0; v < exact.cols(); ++v) {
    square += (x.col(v) - exact.col(v)).squaredNorm();
    of += exact.col(v).squaredNorm();
  }
  result.error = std::sqrt(square / of);
  return result;
}

}  // namespace kerf::evaluation
