#include "tests/bench/solver_large_bench.h"

#include <cstdio>
#include <fstream>
#include <memory>
#include <string>

#include <malloc.h>
#include <unistd.h>

#include "server/fem/linear_solver.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/solver_systems.h"

namespace kerf::bench {
namespace {

using Kind = fem::LinearSolverKind;

constexpr int kMaxIterations = 20000;
constexpr int kMostForBlockJacobi = 10000;  // vertices: beyond, it takes a minute and more

// MB, resident, without what was freed.
double memory() {
  malloc_trim(0);
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  double resident = 0.0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

// s, CPU, of A x.
double time_product(const System& system) {
  constexpr int kProducts = 50;
  mesh::VertexField y(system.b.cols());
  const double begin = process_cpu_s();
  for (int i = 0; i < kProducts; ++i) system.tangent.blocks().multiply(system.b, y);
  return (process_cpu_s() - begin) / kProducts;
}

// One row: from nothing, a factor included, to each tolerance.
void report(Kind kind, const System& system) {
  std::printf("| | %s ", std::string(fem::name_of(kind).option).c_str());
  double analysis = 0.0;
  double megabytes = 0.0;
  for (const double tolerance : {1e-4, 1e-6}) {
    if (kind == Kind::kDirect && tolerance < 1e-4) {
      std::printf("| | | ");  // it knows of no tolerance
      continue;
    }
    const double before = memory();
    const double start = process_cpu_s();
    const std::unique_ptr<fem::LinearSolver> solver = fem::make_linear_solver(kind, kMaxIterations);
    solver->analyse(system.tangent.blocks());
    if (std::vector<Eigen::Matrix3d>* const frames = solver->frames()) *frames = system.frames;
    if (mesh::VertexField* const positions = solver->positions()) *positions = system.positions;
    mesh::VertexField x = Eigen::Matrix3Xd::Zero(3, system.b.cols());
    const double begin = process_cpu_s();
    const fem::LinearStats stats = solver->solve(system.tangent.blocks(), system.b, tolerance, x);
    const double seconds = process_cpu_s() - begin;
    std::printf("| %d%s | %.2g | %.1f ", stats.iterations, stats.converged ? "" : ", not converged", stats.residual,
                1e3 * seconds);
    analysis = begin - start;
    megabytes = memory() - before;
  }
  std::printf("| %.1f | %.0f |\n", 1e3 * analysis, megabytes);
  std::fflush(stdout);
}

void report_all(const char* what, const System& system) {
  std::printf("| %lld, %s | one product A x | | | %.2f | | | | | |\n", static_cast<long long>(system.b.cols()), what,
              1e3 * time_product(system));
  for (const Kind kind : {Kind::kDirect, Kind::kFactorCg, Kind::kMultigridCg}) report(kind, system);
  if (system.b.cols() <= kMostForBlockJacobi) report(Kind::kBlockJacobiCg, system);
}

}  // namespace

void measure_large(std::string_view name, const fem::Material& material, int only_side) {
  std::printf(
      "%s\n\n| vertices, step | solver | to 1e-4: iterations | true residual | ms | to 1e-6: iterations | true "
      "residual | ms "
      "| ms, analysis of the pattern | MB |\n|---|---|---|---|---|---|---|---|---|---|\n",
      std::string(name).c_str());
  const FallenSheet fallen = let_fall(material, kMostFallen);
  for (const int side : {50, 100, 200, 320}) {
    if (only_side != 0 && side != only_side) continue;
    const FallenSheet whole = refine(fallen, material, make_sheet(side, false), side);
    report_all("1/240 s", linearise(whole, 1.0 / 240.0));
    report_all("1/60 s", linearise(whole, 1.0 / 60.0));
    report_all("1 s", linearise(whole, 1.0));
    const FallenSheet slit = refine(fallen, material, make_sheet(side, true), side);
    report_all("slits, 1/60 s", linearise(slit, 1.0 / 60.0));
  }
  std::printf("\n");
}

}  // namespace kerf::bench
