#include <cstdint>
#include <string>
#include <string_view>

#include <benchmark/benchmark.h>

#include "server/base/state_hash.h"
#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"

// Measures how long a sheet is kept from ticking while it is saved, after some cuts that it could undo.
namespace kerf::bench {
namespace {

void save(benchmark::State& state) {
  const int side = kGridSides[state.range(0)];
  sheet::Sheet sheet = swinging_cloth(side, scene::IntegratorKind::kExplicitLeapfrog);
  (void)sheet;
  for (int i = 0; i < 10; ++i) sheet.step({});
  std::string bytes;
  for (auto _ : state) {
    bytes = {};
    sheet.save([&](std::string_view part) { bytes += part; });
    benchmark::DoNotOptimize(bytes);
  }
  state.counters["bytes"] = static_cast<double>(bytes.size());
}
BENCHMARK(save)->DenseRange(0, 3);

}  // namespace
}  // namespace kerf::bench
