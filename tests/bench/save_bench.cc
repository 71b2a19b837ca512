#include <cstddef>
#include <string>
#include <string_view>

#include <benchmark/benchmark.h>

#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"

// Measures how long saving a sheet keeps it from its next tick.
namespace kerf::bench {
namespace {

void save(benchmark::State& state, const std::string& name, int side) {
  sheet::Sheet sheet = swinging_cloth(side, scene::IntegratorKind::kExplicitLeapfrog);
  const scene::Command cut = s_cut();
  sheet.step({&cut, 1});
  for (int tick = 0; tick < 5; ++tick) sheet.step({});
  std::size_t num_bytes = 0;
  for (auto _ : state) {
    std::string bytes;
    bytes.reserve(num_bytes);
    sheet.save([&](std::string_view part) { bytes += part; });
    num_bytes = bytes.size();
    benchmark::DoNotOptimize(bytes.data());
  }
  state.counters["bytes"] = static_cast<double>(num_bytes);
  expect_hash(state, name, sheet.continuation_hash());
}

const bool kSaveRegistered = [] {
  for (const int side : kGridSides) {
    const std::string name = "save/" + std::to_string(side * side);
    benchmark::RegisterBenchmark(name.c_str(), [name, side](benchmark::State& state) {
      save(state, name, side);
    })->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench
