// Measures how local inertia changes the motion of randomly cut sheets: ticks of 1/60 s with it and without, and how
// far the two are apart. What such ticks cost beside an uncut sheet is kerf_bench's random_cuts.
//   random_cuts_error_bench [--schemes] [MATERIAL [SEED [CUTS...]]]   such as demo 14159265 0 1 5 10 20 50 100
// --schemes: run time against error of other integrators, too, in place of that table.
// The error is that of a vertex after 0.05 s, against plain leapfrog in double on the same mesh; both have the damping
// that plain leapfrog can carry. "-": plain leapfrog would take more than kMostPlain substeps a tick. Schemes are
// compared with plain leapfrog of a quarter of its step.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/core/fem/step/explicit_integrator.h"
#include "server/core/mesh/triangle_mesh.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/random_cuts_scene.h"

namespace kerf::bench {
namespace {

constexpr double kTick = 1.0 / 60.0;
constexpr int kTicks = 24;
constexpr double kErrorTime = 0.05;  // s
constexpr double kMostPlain = 6000.0;
constexpr double kMostPlainOfReference = 20'000.0;

fem::IntegratorOptions options_of(bool has_local_inertia, fem::Precision precision) {
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kExplicit;
  options.has_local_inertia = has_local_inertia;
  options.precision = precision;
  options.max_substeps = 100'000;
  return options;
}

// With a ripple of 1 mm, so that it is not quite flat.
fem::State start_of(const sheet::Sheet& sheet) {
  fem::State state = sheet.state();
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    const Eigen::Vector2d p = sheet.mesh().rest_position(v);
    state.x(2, v) += 1e-3 * std::sin(9.0 * p.x()) * std::cos(7.0 * p.y());
  }
  return state;
}

fem::Loads loads_of(const sheet::Sheet& sheet, const fem::State& start) {
  fem::Loads loads;
  for (const mesh::VertexId v : sheet.pinned_vertices()) loads.pins.push_back({v, start.x.col(v)});
  return loads;
}

struct Run {
  fem::State state;
  double median_ms = 0.0;  // of a step
  int substeps = 0;
  std::uint32_t flags = 0;
};

Run run(const sheet::Sheet& sheet, const fem::Model& model, const fem::IntegratorOptions& options, double dt,
        int num_steps) {
  const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
  integrator->rebuild(model);
  Run result{start_of(sheet)};
  const fem::Loads loads = loads_of(sheet, result.state);
  std::vector<double> ms;
  for (int i = 0; i < num_steps; ++i) {
    const double before = thread_cpu_s();
    const fem::StepStats stats = integrator->step(model, loads, dt, nullptr, result.state);
    ms.push_back(1e3 * (thread_cpu_s() - before));
    result.substeps = stats.substeps;
    result.flags |= stats.flags;
  }
  result.median_ms = median_of(std::move(ms));
  return result;
}

double plain_substeps(const fem::Model& model) {
  fem::ExplicitIntegrator plain(options_of(false, fem::Precision::kDouble));
  plain.plan(model, false);
  return plain.planned_substeps(kTick);
}

// With a damping ratio of 0.1 in the fastest mode, which plain leapfrog can carry.
fem::Model damped_model(const sheet::Sheet& sheet, fem::Material material) {
  material.stiffness_damping = 0.2 / std::sqrt(sheet.model().stiffness_bound().value());
  return {sheet.mesh(), material};
}

// Errors of vertices, mm: "p99 / largest".
std::string difference(const Run& expected, const Run& found) {
  std::vector<double> errors;
  for (Eigen::Index v = 0; v < found.state.x.cols(); ++v) {
    errors.push_back(1e3 * (found.state.x.col(v) - expected.state.x.col(v)).norm());
  }
  std::sort(errors.begin(), errors.end());
  char text[64];
  std::snprintf(text, sizeof text, "%.2g / %.2g", errors[errors.size() * 99 / 100], errors.back());
  return text;
}

std::string error_of(const sheet::Sheet& sheet, const fem::Material& material) {
  const fem::Model model = damped_model(sheet, material);
  constexpr int kSteps = 3;
  const Run expected = run(sheet, model, options_of(false, fem::Precision::kDouble), kErrorTime / kSteps, kSteps);
  return difference(expected, run(sheet, model, options_of(true, fem::Precision::kMixed), kErrorTime / kSteps, kSteps));
}

struct Scheme {
  const char* name;
  fem::IntegratorOptions options;
  int num_steps;  // in kErrorTime
};

fem::IntegratorOptions implicit_options(fem::IntegratorKind kind) {
  fem::IntegratorOptions options;
  options.kind = kind;
  options.linear_solver = linear::LinearSolverKind::kDirect;
  return options;
}

std::vector<Scheme> schemes() {
  using enum fem::IntegratorKind;
  return {
      {"local inertia, mixed precision (default)", options_of(true, fem::Precision::kMixed), 3},
      {"local inertia, double", options_of(true, fem::Precision::kDouble), 3},
      {"plain leapfrog, mixed precision", options_of(false, fem::Precision::kMixed), 3},
      {"TR-BDF2, 60 Hz", implicit_options(kTrBdf2), 3},
      {"TR-BDF2, 240 Hz", implicit_options(kTrBdf2), 12},
      {"TR-BDF2, 960 Hz", implicit_options(kTrBdf2), 48},
      {"implicit Euler, 60 Hz", implicit_options(kImplicitEuler), 3},
      {"implicit Euler, 960 Hz", implicit_options(kImplicitEuler), 48},
  };
}

void compare_schemes(const sheet::Sheet& sheet, const fem::Material& material, int num_cuts) {
  if (plain_substeps(sheet.model()) > kMostPlainOfReference) {
    std::printf("| %d | no reference: plain leapfrog takes too many substeps | | |\n", num_cuts);
    return;
  }
  const fem::Model model = damped_model(sheet, material);
  fem::IntegratorOptions fine = options_of(false, fem::Precision::kDouble);
  fine.cfl = 0.25;
  const Run expected = run(sheet, model, fine, kErrorTime / 3, 3);
  for (const Scheme& scheme : schemes()) {
    const Run found = run(sheet, model, scheme.options, kErrorTime / scheme.num_steps, scheme.num_steps);
    std::printf("| %d | %s | %.2f | %s |\n", num_cuts, scheme.name, found.median_ms * scheme.num_steps / 3,
                difference(expected, found).c_str());
    std::fflush(stdout);
  }
}

int main_of(int argc, char** argv) {
  const bool has_schemes = argc > 1 && std::string_view(argv[1]) == "--schemes";
  if (has_schemes) {
    --argc;
    ++argv;
  }
  const std::string name = argc > 1 ? argv[1] : "demo";
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : kPiSeeds[0];
  std::vector<int> counts;
  for (int i = 3; i < argc; ++i) counts.push_back(std::atoi(argv[i]));
  if (counts.empty()) counts = {0, 1, 5, 10, 20, 50, 100};
  const Result<fem::Material> material = fem::find_preset(name);
  if (!material.ok()) {
    std::fprintf(stderr, "random_cuts_error_bench: %s\n", material.error().message.c_str());
    return 2;
  }
  sheet::Sheet sheet = cloth_to_cut(*material, CutScene::kHung);
  RandomCutter cutter(seed);
  std::printf("%s, seed %llu\n", name.c_str(), static_cast<unsigned long long>(seed));
  if (has_schemes) {
    std::printf("| cuts | scheme | ms a tick | error mm, p99 / largest |\n|---|---|---|---|\n");
    int made = 0;
    for (const int count : counts) {
      for (; made < count; ++made) cutter.cut(sheet);
      compare_schemes(sheet, *material, count);
    }
    return 0;
  }
  std::printf("| cuts | vertices | plain substeps | ms | substeps | ms | error mm, p99 / largest | flags |\n");
  std::printf("|---|---|---|---|---|---|---|---|\n");
  int made = 0;
  for (const int count : counts) {
    for (; made < count; ++made) cutter.cut(sheet);
    const double of_plain = plain_substeps(sheet.model());
    std::string plain_ms = "-", error = "-";
    if (of_plain <= kMostPlain) {
      char text[32];
      const Run plain = run(sheet, sheet.model(), options_of(false, fem::Precision::kMixed), kTick, 4);
      std::snprintf(text, sizeof text, "%.1f", plain.median_ms);
      plain_ms = text;
      error = error_of(sheet, *material);
    }
    const Run tested = run(sheet, sheet.model(), options_of(true, fem::Precision::kMixed), kTick, kTicks);
    std::printf("| %d | %d | %.0f | %s | %d | %.2f | %s | %x |\n", count, sheet.mesh().num_vertices(), of_plain,
                plain_ms.c_str(), tested.substeps, tested.median_ms, error.c_str(), tested.flags);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  return kerf::bench::main_of(argc, argv);
}
