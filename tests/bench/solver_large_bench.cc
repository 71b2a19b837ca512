#include "tests/bench/solver_large_bench.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include <malloc.h>
#include <unistd.h>

#include "server/base/check.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/linear/linear_solver.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/solver_system.h"

namespace kerf::bench {
namespace {

using Kind = linear::LinearSolverKind;

constexpr int kMaxIterations = 20000;
constexpr int kMostForBlockJacobi = 10000;  // vertices: beyond, it takes a minute and more

constexpr double kTick = 1.0 / 60.0;           // s
constexpr int kTicks = 30;                     // from the horizontal
constexpr double kSettlingStep = 1.0 / 240.0;  // s
constexpr int kMostFallen = 50;                // vertices along a side: the fall of a large sheet takes hours

// A sheet of 1 m x 1 m that has fallen from the horizontal, two corners pinned.
struct FallenSheet {
  mesh::TriangleMesh mesh;
  fem::Model model;
  fem::Loads loads;
  fem::State state;
};

FallenSheet lay_flat(mesh::TriangleMesh mesh, const fem::Material& material, int side) {
  fem::Model model(mesh, material);
  fem::Loads loads = corners_pinned(mesh, side);
  fem::State state = flat(mesh);
  return {std::move(mesh), std::move(model), std::move(loads), std::move(state)};
}

FallenSheet let_fall(const fem::Material& material) {
  const int side = kMostFallen;
  FallenSheet sheet = lay_flat(mesh::make_grid({.num_x = side, .num_y = side}).value(), material, side);
  fall(sheet.model, sheet.loads, kTick, kTicks, sheet.state);
  return sheet;
}

// A grid of side x side vertices; with `slits`, cut through four times along 0.6 m.
mesh::TriangleMesh make_sheet(int side, bool slits) {
  mesh::TriangleMesh mesh = mesh::make_grid({.num_x = side, .num_y = side}).value();
  if (!slits) return mesh;
  for (const double y : {0.213, 0.413, 0.613, 0.813}) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {cut::Polyline{{{0.2, y}, {0.8, y + 0.01}}}, {}, {}});
    KERF_CHECK(plan.ok(), "slits are within the sheet");
    KERF_CHECK(cut::apply(mesh, *plan).ok(), "slits are within the sheet");
  }
  return mesh;
}

// Interpolates a grid of side x side vertices on the unit square at `rest`, linearly in its triangles.
Eigen::Vector3d interpolate(const linear::VertexField& field, int side, const Eigen::Vector2d& rest) {
  const Eigen::Vector2d scaled = rest * (side - 1);
  const int i = std::clamp(static_cast<int>(scaled.x()), 0, side - 2);
  const int j = std::clamp(static_cast<int>(scaled.y()), 0, side - 2);
  const double a = scaled.x() - i;
  const double b = scaled.y() - j;
  const int corner = j * side + i;
  const Eigen::Vector3d across = field.col(corner + side + 1);
  if (a >= b) return (1.0 - a) * field.col(corner) + (a - b) * field.col(corner + 1) + b * across;
  return (1.0 - b) * field.col(corner) + (b - a) * field.col(corner + side) + a * across;
}

// `fallen` on the mesh of make_sheet, and then a step.
FallenSheet refine(const FallenSheet& fallen, const fem::Material& material, mesh::TriangleMesh mesh, int side) {
  FallenSheet sheet = lay_flat(std::move(mesh), material, side);
  for (int v = 0; v < sheet.mesh.num_vertices(); ++v) {
    sheet.state.x.col(v) = interpolate(fallen.state.x, kMostFallen, sheet.mesh.rest_position(v));
    sheet.state.v.col(v) = interpolate(fallen.state.v, kMostFallen, sheet.mesh.rest_position(v));
  }
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kImplicitEuler;
  options.linear_solver = linear::LinearSolverKind::kFactorCg;
  const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
  integrator->rebuild(sheet.model);
  integrator->step(sheet.model, sheet.loads, kSettlingStep, nullptr, sheet.state);
  return sheet;
}

System linearise(const FallenSheet& sheet, double dt) {
  return system_at(sheet.model, sheet.loads, sheet.state, dt);
}

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
  linear::VertexField y(system.b.cols());
  const double begin = process_cpu_s();
  for (int i = 0; i < kProducts; ++i) system.tangent.blocks().multiply(system.b, y);
  return (process_cpu_s() - begin) / kProducts;
}

// One row: from nothing, a factor included, to each tolerance.
void report(Kind kind, const System& system) {
  std::printf("| | %s ", std::string(linear::name_of(kind).option).c_str());
  double analysis = 0.0;
  double megabytes = 0.0;
  for (const double tolerance : {1e-4, 1e-6}) {
    if (kind == Kind::kDirect && tolerance < 1e-4) {
      std::printf("| | | ");  // it knows of no tolerance
      continue;
    }
    const double before = memory();
    const double start = process_cpu_s();
    const std::unique_ptr<linear::LinearSolver> solver = linear::make_linear_solver(kind, kMaxIterations);
    solver->analyse(system.tangent.blocks());
    if (std::vector<Eigen::Matrix3d>* const frames = solver->frames()) *frames = system.frames;
    if (linear::VertexField* const positions = solver->positions()) *positions = system.positions;
    linear::VertexField x = Eigen::Matrix3Xd::Zero(3, system.b.cols());
    const double begin = process_cpu_s();
    const linear::LinearStats stats = solver->solve(system.tangent.blocks(), system.b, tolerance, x);
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
  const FallenSheet fallen = let_fall(material);
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
