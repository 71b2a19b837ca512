#include <string>

#include <benchmark/benchmark.h>

#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"

namespace kerf::bench {
namespace {

constexpr int kWarmUpTicks = 2;

void step(benchmark::State& state, const std::string& name, int side, sheet::IntegratorKind integrator) {
  sheet::Sheet sheet = swinging_cloth(side, integrator);
  for (int tick = 0; tick < kWarmUpTicks; ++tick) sheet.step({});
  double substeps = 0.0;
  double linear_iterations = 0.0;
  for (auto _ : state) {
    const sheet::TickReport report = sheet.step({});
    substeps += report.stats.substeps;
    linear_iterations += report.stats.linear_iterations;
  }
  state.counters["substeps"] = benchmark::Counter(substeps, benchmark::Counter::kAvgIterations);
  state.counters["linear_iterations"] = benchmark::Counter(linear_iterations, benchmark::Counter::kAvgIterations);
  expect_hash(state, name, sheet.state_hash());
}

const bool kRegistered = [] {
  for (const auto& [label, integrator] : {std::pair("explicit", sheet::IntegratorKind::kExplicitLeapfrog),
                                          std::pair("implicit", sheet::IntegratorKind::kImplicitEuler)}) {
    for (const int side : kGridSides) {
      const std::string name = std::string("step/") + label + "/" + std::to_string(side * side);
      const auto kind = integrator;
      benchmark::RegisterBenchmark(name.c_str(),
                                   [name, side, kind](benchmark::State& state) { step(state, name, side, kind); })
          ->Iterations(side <= 50    ? 60
                       : side <= 100 ? 10
                                     : 3)
          ->Unit(benchmark::kMicrosecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench
