// The tables of tests/bench/notes/race.md: the scene at which other programs are compared, per tick of 1/60 s.
//   race_bench [MESH [PROGRAM]]: with PROGRAM, a part of a name, the tables of programs and schemes alone
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/fem/element/state.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/race_one_solve.h"
#include "tests/bench/race_programs.h"
#include "tests/bench/race_scene.h"

namespace kerf::bench {
namespace {

constexpr double kWorstError = 1e-4;       // m, of a vertex
constexpr double kWorstDifference = 1e-3;  // m, of a vertex: of another law at strains up to some 1 %

struct Variant {
  const char* label;
  fem::Precision precision;
  fem::MembraneLaw law;
  double worst_error;  // m, of a vertex, against the co-rotational reference
};
constexpr Variant kVariants[] = {
    {"double", fem::Precision::kDouble, fem::MembraneLaw::kCorotational, kWorstError},
    {"mixed", fem::Precision::kMixed, fem::MembraneLaw::kCorotational, kWorstError},
    {"double, Green", fem::Precision::kDouble, fem::MembraneLaw::kGreen, kWorstDifference},
    {"mixed, Green", fem::Precision::kMixed, fem::MembraneLaw::kGreen, kWorstDifference},
};

struct Sheet {
  std::string name;
  double compared_at;  // s, with the reference
  mesh::TriangleMesh mesh;
  fem::Material material = cloth();
};

Sheet wool_sheet() {
  return {"50x50, wool", 0.3, grid(50), *fem::find_preset("wool")};
}

struct Run {
  std::vector<double> ms;  // CPU, of each tick
  int substeps = 0;        // of the last tick
  double max_strain = 0.0;
  std::uint32_t flags = 0;
  long linear_iterations = 0;    // of all ticks
  double linear_residual = 0.0;  // -, largest of a solve, |b - A x| / |b|
  int repaired = 0;              // ticks that needed more than the scheme asks for, see fem::kRepaired
};

using MakeIntegrator = std::function<std::unique_ptr<fem::Integrator>()>;

MakeIntegrator make_with(const fem::IntegratorOptions& options) {
  return [options] { return fem::make_integrator(options); };
}

Run run(Scene& scene, const MakeIntegrator& make, double duration) {
  const std::unique_ptr<fem::Integrator> integrator = make();
  integrator->rebuild(scene.model);
  Run result;
  for (long i = 0; i < std::lround(duration / kTick); ++i) {
    const double begin = thread_cpu_s();
    const fem::StepStats stats = integrator->step(scene.model, scene.loads, kTick, nullptr, scene.state);
    result.ms.push_back(1e3 * (thread_cpu_s() - begin));
    result.substeps = stats.substeps;
    result.max_strain = std::max(result.max_strain, stats.max_strain);
    result.flags |= stats.flags;
    result.repaired += (stats.flags & fem::kRepaired) != 0 ? 1 : 0;
    result.linear_iterations += stats.linear_iterations;
    result.linear_residual = std::max(result.linear_residual, stats.linear_residual);
  }
  return result;
}

fem::State state_of(const Sheet& sheet, const MakeIntegrator& make, fem::MembraneLaw law) {
  Scene scene(sheet.mesh, 0.0, false, law, sheet.material);
  run(scene, make, sheet.compared_at);
  return scene.state;
}

bool measure(const Sheet& sheet) {
  const fem::State reference = state_of(sheet, make_with(reference_options()), fem::MembraneLaw::kCorotational);
  bool all_good = true;
  for (const Variant& variant : kVariants) {
    const MakeIntegrator make = make_with(explicit_options(variant.precision));
    const fem::State tested = state_of(sheet, make, variant.law);
    const double error = (tested.x - reference.x).colwise().norm().maxCoeff();
    Scene swing(sheet.mesh, 2.0, false, variant.law, sheet.material);
    Run result = run(swing, make, 2.0);
    std::sort(result.ms.begin(), result.ms.end());
    const double median = result.ms[result.ms.size() / 2];
    const bool is_good = error <= variant.worst_error && result.flags == 0;
    std::printf("| %s | %s | %d | %.2f | %.2f | %.1f | %.4f | %.2f %% |%s\n", sheet.name.c_str(), variant.label,
                result.substeps, median, result.ms.back(), 1e3 * median / (result.substeps + 2), 1e3 * error,
                100.0 * result.max_strain, is_good ? "" : " FAILED");
    std::fflush(stdout);
    all_good = all_good && is_good;
  }
  return all_good;
}

bool measure_sheets(std::string_view only) {
  const std::vector<Sheet> sheets{
      {"50x50", 0.3, grid(50)},
      {"81x81", 0.3, grid(81)},
      {"160x160", 0.3, grid(160)},
      {"50x50 Delaunay", 0.3, mesh::make_jittered_grid({.num_x = 50, .num_y = 50}, 1).value()},
      // Later its flaps buckle, which way depends on damping: 1.2 mm at 0.3 s from that alone.
      {"50x50, 20 cuts", 0.1, cut_grid(50)},
      wool_sheet(),
  };
  std::printf(
      "| mesh | precision | substeps | median ms | worst ms | us a substep | error mm | largest strain |\n"
      "|---|---|---|---|---|---|---|---|\n");
  bool is_good = true;
  for (const Sheet& sheet : sheets) {
    if (sheet.name.find(only) != std::string::npos) is_good = measure(sheet) && is_good;
  }
  std::printf("\n");
  return is_good;
}

struct Scheme {
  const char* name;
  MakeIntegrator make;
};

// The explicit integrator, the source's scheme as it is and with what Kerf does where its one solve goes wrong, and
// better implicit ones; ticks of 1/60 s.
std::vector<Scheme> schemes() {
  using Solver = linear::LinearSolverKind;
  const auto one_solve = [](Solver solver) { return [solver] { return make_one_solve(solver); }; };
  const auto implicit = [](fem::IntegratorKind kind, int newton_iterations, Solver solver) {
    return make_with(implicit_options(kind, newton_iterations, solver));
  };
  return {
      {"explicit, mixed", make_with(explicit_options(fem::Precision::kMixed))},
      {"the source's: implicit Euler, 1 solve, plain CG", one_solve(Solver::kPlainCg)},
      {"the same, block-Jacobi CG", one_solve(Solver::kBlockJacobiCg)},
      {"the same, direct", one_solve(Solver::kDirect)},
      {"1 solve and Kerf's repair, direct", implicit(fem::IntegratorKind::kImplicitEuler, 1, Solver::kDirect)},
      {"implicit Euler, 5 Newton, factor", implicit(fem::IntegratorKind::kImplicitEuler, 5, Solver::kFactorCg)},
      {"TR-BDF2, 5 Newton, factor", implicit(fem::IntegratorKind::kTrBdf2, 5, Solver::kFactorCg)},
  };
}

// A quarter of the swing is timed: ticks of plain CG take seconds.
void compare_schemes(const Sheet& sheet, std::string_view only) {
  constexpr auto kLaw = fem::MembraneLaw::kCorotational;
  constexpr double kTimed = 0.5;  // s
  const fem::State reference = state_of(sheet, make_with(reference_options()), kLaw);
  std::printf(
      "| %s: scheme | median ms | worst ms | error mm | linear iterations a tick | worst linear residual | "
      "ticks repaired of %ld |\n|---|---|---|---|---|---|---|\n",
      sheet.name.c_str(), std::lround(kTimed / kTick));
  for (const auto& [name, make] : schemes()) {
    if (std::string_view(name).find(only) == std::string_view::npos) continue;
    const fem::State tested = state_of(sheet, make, kLaw);
    const double error = (tested.x - reference.x).colwise().norm().maxCoeff();
    Scene swing(sheet.mesh, 2.0, false, kLaw, sheet.material);
    Run result = run(swing, make, kTimed);
    std::sort(result.ms.begin(), result.ms.end());
    const auto num_ticks = static_cast<double>(result.ms.size());
    std::printf("| %s | %.2f | %.2f | %.4f | %.0f | %.1e | %d |\n", name, result.ms[result.ms.size() / 2],
                result.ms.back(), 1e3 * error, static_cast<double>(result.linear_iterations) / num_ticks,
                result.linear_residual, result.repaired);
    std::fflush(stdout);
  }
  std::printf("\n");
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  using namespace kerf::bench;
  const std::string_view only = argc > 1 ? argv[1] : "";
  const std::string_view program = argc > 2 ? argv[2] : "";
  bool is_good = argc > 2 || measure_sheets(only);
  if (const Sheet wool = wool_sheet(); wool.name.find(only) != std::string::npos) compare_schemes(wool, program);
  for (const int side : {50, 81}) {
    const std::string name = std::to_string(side) + "x" + std::to_string(side);
    const bool is_asked = only.empty() ? side == 50 : name.find(only) != std::string::npos;
    if (is_asked) is_good = compare_programs(name, side, program) && is_good;
  }
  return is_good ? 0 : 1;
}
