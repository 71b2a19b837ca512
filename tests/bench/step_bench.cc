#include <string>
#include <utility>

#include <benchmark/benchmark.h>

#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"

namespace kerf::bench {
namespace {

struct Scene {
  const char* name;
  sheet::Sheet (*make)(int side, scene::IntegratorKind integrator);
  int warm_up_ticks;
  int largest_side;
};

constexpr Scene kScenes[] = {{"step", swinging_cloth, 2, 200}, {"drape", draped_cloth, 15, 50}};

constexpr std::pair<const char*, scene::IntegratorKind> kIntegrators[] = {
    {"explicit", scene::IntegratorKind::kExplicitLeapfrog}, {"implicit", scene::IntegratorKind::kImplicitEuler}};

void step(benchmark::State& state, const std::string& name, sheet::Sheet sheet, int warm_up_ticks) {
  for (int tick = 0; tick < warm_up_ticks; ++tick) sheet.step({});
  fem::StepStats sum;
  for (auto _ : state) {
    const sheet::TickReport report = sheet.step({});
    sum.substeps += report.stats.substeps;
    sum.newton_iterations += report.stats.newton_iterations;
    sum.linear_iterations += report.stats.linear_iterations;
  }
  const auto count = [&state](const char* counter, int total) {
    state.counters[counter] = benchmark::Counter(total, benchmark::Counter::kAvgIterations);
  };
  count("substeps", sum.substeps);
  count("newton_iterations", sum.newton_iterations);
  count("linear_iterations", sum.linear_iterations);
  expect_hash(state, name, sheet.state_hash());
}

int ticks_at(int side) {
  if (side <= 50) return 60;
  return side <= 100 ? 10 : 3;
}

const bool kStepRegistered = [] {
  for (const Scene& scene : kScenes) {
    for (const auto& [label, kind] : kIntegrators) {
      for (const int side : kGridSides) {
        if (side > scene.largest_side) continue;
        const std::string name = std::string(scene.name) + "/" + label + "/" + std::to_string(side * side);
        const auto run = [name, scene, side, integrator = kind](benchmark::State& state) {
          step(state, name, scene.make(side, integrator), scene.warm_up_ticks);
        };
        benchmark::RegisterBenchmark(name.c_str(), run)->Iterations(ticks_at(side))->Unit(benchmark::kMicrosecond);
      }
    }
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench
