#include <string>

#include <benchmark/benchmark.h>

#include "server/base/check.h"
#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"

namespace kerf::bench {
namespace {

void cut(benchmark::State& state, const std::string& name, int side) {
  const sheet::Sheet whole = swinging_cloth(side, scene::IntegratorKind::kExplicitLeapfrog);
  const scene::Command command = s_cut();
  std::uint64_t hash = 0;
  cut::CutReport report;
  for (auto _ : state) {
    state.PauseTiming();
    sheet::Sheet sheet = whole;
    state.ResumeTiming();
    const sheet::TickReport done = sheet.apply({&command, 1});
    state.PauseTiming();
    KERF_CHECK(done.replies.size() == 1 && done.replies[0].ok(), "the benchmark's cut is refused");
    report = done.replies[0]->cut->report;
    hash = sheet.state_hash();
    state.ResumeTiming();
  }
  state.counters["crossed_triangles"] = report.crossed_triangles;
  state.counters["new_triangles"] = report.new_triangles;
  state.counters["s/crossed_triangle"] = benchmark::Counter(
      report.crossed_triangles, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  expect_hash(state, name, hash);
}

const bool kCutRegistered = [] {
  for (const int side : kGridSides) {
    const std::string name = "cut/" + std::to_string(side * side);
    benchmark::RegisterBenchmark(name.c_str(), [name, side](benchmark::State& state) { cut(state, name, side); })
        ->Iterations(20)
        ->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench
