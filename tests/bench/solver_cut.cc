#include "tests/bench/solver_cut.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/base/check.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/transfer.h"
#include "server/core/linear/conjugate_gradient.h"
#include "server/core/linear/factor_preconditioner.h"
#include "server/core/linear/linear_solver.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/bench/corrected_factor.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/solver_system.h"
#include "tests/support/cut_patterns.h"

namespace kerf::bench {
namespace {

constexpr double kTick = 1.0 / 60.0;  // s
constexpr int kTicks = 20;            // from the horizontal to the cut
constexpr double kTolerances[] = {1e-3, 1e-4, 1e-6};
constexpr int kMaxIterations = 3000;

// A sheet before the cut, now and earlier, and after it.
struct Falling {
  mesh::TriangleMesh mesh;
  fem::Model before;
  fem::Loads loads;
  fem::State a_tick_ago, a_tenth_ago, now;
  fem::Model after;
  fem::State after_cut;
  std::vector<int> rewritten;  // vertices of rewritten triangles, ascending
  std::vector<int> changed;    // rows of the matrix that changed, ascending
};

Falling make_falling(const fem::Material& material, int side) {
  mesh::TriangleMesh mesh = mesh::make_grid({.num_x = side, .num_y = side}).value();
  const fem::Model model(mesh, material);
  Falling sheet{mesh, model, corners_pinned(mesh, side), {}, {}, {}, model, {}, {}, {}};
  fem::State state = flat(mesh);
  fall(model, sheet.loads, kTick, kTicks - 1, state);
  sheet.a_tick_ago = state;
  fall(model, sheet.loads, kTick / 10.0, 9, state);
  sheet.a_tenth_ago = state;
  fall(model, sheet.loads, kTick / 10.0, 1, state);
  sheet.now = state;

  std::vector<mesh::MeshEdit> edits;
  std::set<int> rewritten;
  for (const cut::Curve& curve : test::kirigami(5, 4)) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {curve, {}, {}});
    KERF_CHECK(plan.ok(), "the benchmark's cut is refused");
    edits.push_back(cut::apply(mesh, *plan).value().edit);
  }
  std::vector<const mesh::MeshEdit*> all;
  std::set<mesh::TriangleId> slots;
  for (const mesh::MeshEdit& edit : edits) {
    all.push_back(&edit);
    slots.insert(edit.rewritten_triangles.begin(), edit.rewritten_triangles.end());
  }
  for (const mesh::TriangleId slot : slots) {
    if (mesh.is_solid(slot)) rewritten.insert(mesh.vertices(slot).begin(), mesh.vertices(slot).end());
  }
  const fem::MassChange change = sheet.after.follow(mesh, {slots.begin(), slots.end()});
  fem::transfer_state(all, sheet.after, change, state);
  sheet.after_cut = state;
  sheet.rewritten.assign(rewritten.begin(), rewritten.end());
  const std::set<int> changed(sheet.after.changed_rows().begin(), sheet.after.changed_rows().end());
  sheet.changed.assign(changed.begin(), changed.end());
  return sheet;
}

struct Solved {
  linear::VertexField x;
  linear::LinearStats stats;
  double setup = 0.0;  // s, CPU
  double solve = 0.0;  // s, CPU
};
using Solve = std::function<Solved(double tolerance)>;

Solve from_nothing(linear::LinearSolverKind kind, const System& system) {
  return [kind, &system](double tolerance) {
    const std::unique_ptr<linear::LinearSolver> solver = linear::make_linear_solver(kind, kMaxIterations);
    Solved solved;
    const double start = thread_cpu_s();
    solver->analyse(system.tangent.blocks());
    const double begin = thread_cpu_s();
    if (std::vector<Eigen::Matrix3d>* const frames = solver->frames()) *frames = system.frames;
    solved.x = Eigen::Matrix3Xd::Zero(3, system.b.cols());
    solved.stats = solver->solve(system.tangent.blocks(), system.b, tolerance, solved.x);
    solved.solve = thread_cpu_s() - begin;
    solved.setup = begin - start;
    return solved;
  };
}

// The float factor of a system, ready for another with at least its vertices. `seconds`: CPU, of the factor alone.
std::unique_ptr<linear::FactorPreconditioner> factor_of(const System& before, double& seconds) {
  auto factor = std::make_unique<linear::FactorPreconditioner>();
  factor->analyse(before.tangent.blocks());
  *factor->frames() = before.frames;
  KERF_CHECK(factor->prepare(before.tangent.blocks()), "the matrix is positive definite");
  factor->reset();
  const double begin = thread_cpu_s();
  KERF_CHECK(factor->prepare(before.tangent.blocks()), "the matrix is positive definite");
  seconds = thread_cpu_s() - begin;
  return factor;
}

Solve corrected(const System& before, std::vector<int> part, const System& system) {
  double seconds = 0.0;
  const std::shared_ptr<linear::FactorPreconditioner> factor = factor_of(before, seconds);
  std::copy_n(system.frames.begin(), factor->frames()->size(), factor->frames()->begin());
  return [factor, size = static_cast<int>(before.b.cols()), part = std::move(part), &system](double tolerance) {
    auto made = std::make_unique<CorrectedFactor>(*factor, size, part);
    CorrectedFactor& correction = *made;
    linear::ConjugateGradient gradients(std::move(made), kMaxIterations);
    Solved solved;
    const double start = thread_cpu_s();
    gradients.analyse(system.tangent.blocks());
    KERF_CHECK(correction.prepare(system.tangent.blocks()), "a block of a positive definite matrix is");
    const double begin = thread_cpu_s();
    solved.x = Eigen::Matrix3Xd::Zero(3, system.b.cols());
    correction.start(system.b, solved.x);
    solved.stats = gradients.solve(system.tangent.blocks(), system.b, tolerance, solved.x);
    solved.solve = thread_cpu_s() - begin;
    solved.setup = begin - start;
    return solved;
  };
}

struct Row {
  std::string name;
  std::size_t part;  // vertices of S
  Solve solve;
};

// Least times of some. False: not where the direct solver is.
bool report(const Row& row, int repeats, const linear::VertexField& exact) {
  const double largest = exact.colwise().norm().maxCoeff();
  bool is_right = true;
  double setup = std::numeric_limits<double>::max();
  double error = 0.0;  // m
  std::string columns;
  for (const double tolerance : kTolerances) {
    double least = std::numeric_limits<double>::max();
    Solved solved;
    for (int i = 0; i < repeats; ++i) {
      solved = row.solve(tolerance);
      least = std::min(least, solved.solve);
      setup = std::min(setup, solved.setup);
    }
    error = (solved.x - exact).colwise().norm().maxCoeff();
    const std::string iterations =
        solved.stats.converged ? std::to_string(solved.stats.iterations) : "> " + std::to_string(kMaxIterations);
    char text[64];
    std::snprintf(text, sizeof text, " %s | %.1f |", iterations.c_str(), 1e3 * least);
    columns += text;
    // The residual bounds no error: 1e-6 of it is to be a thousandth of the largest step of a vertex.
    if (solved.stats.converged && tolerance == kTolerances[2]) is_right = error < 1e-3 * largest;
  }
  std::printf("| %s | %zu | %.1f |%s %.2g |%s\n", row.name.c_str(), row.part, 1e3 * setup, columns.c_str(), 1e3 * error,
              is_right ? "" : " FAILED");
  std::fflush(stdout);
  return is_right;
}

// `step`: s.
bool measure(const char* name, const Falling& sheet, int side, double step) {
  using Kind = linear::LinearSolverKind;
  const System system = system_at(sheet.after, sheet.loads, sheet.after_cut, step);
  const System now = system_at(sheet.before, sheet.loads, sheet.now, step);
  const System tenth = system_at(sheet.before, sheet.loads, sheet.a_tenth_ago, step);
  const System tick = system_at(sheet.before, sheet.loads, sheet.a_tick_ago, step);
  double seconds = 0.0;
  factor_of(now, seconds);
  const linear::VertexField exact = from_nothing(Kind::kDirect, system)(0.0).x;
  const linear::VertexField exact_uncut = from_nothing(Kind::kDirect, now)(0.0).x;
  std::printf(
      "%s, %d x %d vertices, %td new, 1/%.0f s; the largest step of a vertex is %.1f mm; a float factor of the matrix "
      "before the cut, its pattern known, takes %.1f ms\n\n"
      "| solver | vertices of S | ms, setup | to 1e-3: iterations | ms | to 1e-4 | ms | to 1e-6 | ms | error mm |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n",
      name, side, side, system.b.cols() - now.b.cols(), 1.0 / step, 1e3 * exact.colwise().norm().maxCoeff(),
      1e3 * seconds);
  const int repeats = side <= 50 ? 7 : 2;
  const std::vector<int>& rewritten = sheet.rewritten;
  const std::vector<int>& changed = sheet.changed;
  bool is_right = true;
  for (const Row& row : {
           Row{"direct", 0, from_nothing(Kind::kDirect, system)},
           Row{"factor-cg", 0, from_nothing(Kind::kFactorCg, system)},
           Row{"block-jacobi-cg", 0, from_nothing(Kind::kBlockJacobiCg, system)},
           Row{"S - old - S, old of this state", rewritten.size(), corrected(now, rewritten, system)},
           Row{"the same, S all changed rows", changed.size(), corrected(now, changed, system)},
           Row{"S - old - S, old of a tenth of a tick ago", rewritten.size(), corrected(tenth, rewritten, system)},
           Row{"S - old - S, old of a tick ago", rewritten.size(), corrected(tick, rewritten, system)},
       }) {
    // Takes minutes for large sheets.
    if (side > 50 && row.name == "block-jacobi-cg") continue;
    is_right = report(row, repeats, exact) && is_right;
  }
  for (const Row& row : {
           Row{"uncut: factor-cg", 0, from_nothing(Kind::kFactorCg, now)},
           Row{"uncut: old of a tenth of a tick ago", 0, corrected(tenth, {}, now)},
           Row{"uncut: old of a tick ago", 0, corrected(tick, {}, now)},
       }) {
    is_right = report(row, repeats, exact_uncut) && is_right;
  }
  std::printf("\n");
  return is_right;
}

}  // namespace

bool measure_after_cut(const char* name, const fem::Material& material, int side) {
  const Falling sheet = make_falling(material, side);
  bool is_right = true;
  for (const double step : {1.0 / 60.0, 1.0 / 240.0}) is_right = measure(name, sheet, side, step) && is_right;
  return is_right;
}

}  // namespace kerf::bench
