// The tables of tests/bench/notes/threads-and-memory.md: memory of a sheet, and what sheets cost that are asleep.
//   footprint_bench [SHEETS]     10,000 sheets sleep; none with 0
#include <malloc.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>

#include "server/base/check.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/service/host/entropy.h"
#include "server/service/host/host.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/scenes.h"
#include "tests/support/scenes.h"
#include "tests/support/self_contact_scenes.h"

namespace kerf::bench {
namespace {

// Bytes, of all that is allocated and not freed.
double allocated() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

struct Setting {
  const char* name;
  scene::IntegratorKind kind;
  scene::Precision precision;
};

constexpr Setting kSettings[] = {
    {"explicit, mixed", scene::IntegratorKind::kExplicitLeapfrog, scene::Precision::kMixed},
    {"explicit, double", scene::IntegratorKind::kExplicitLeapfrog, scene::Precision::kDouble},
    {"implicit", scene::IntegratorKind::kImplicitEuler, scene::Precision::kDouble},
};

void print_memory() {
  std::printf("| vertices |");
  for (const Setting& setting : kSettings) std::printf(" %s | with a snapshot |", setting.name);
  std::printf("\n|---|---|---|---|---|---|---|\n");
  for (const int side : {15, 50, 100, 200}) {
    std::printf("| %d |", side * side);
    for (const Setting& setting : kSettings) {
      const double before = allocated();
      sheet::Sheet sheet = race_cloth(side, setting.kind, setting.precision);
      for (int tick = 0; tick < 2; ++tick) sheet.step({});
      const double used = allocated() - before;
      const auto snapshot = sheet.snapshot();
      const double watched = allocated() - before;
      std::printf(" %.0f | %.0f |", used / (side * side), watched / (side * side));
    }
    std::printf("\n");
    std::fflush(stdout);
  }
}

// Bytes a vertex that a sheet holds after some ticks.
double held(scene::SheetConfig config, bool touches_itself, int ticks) {
  config.self_contact.is_on = touches_itself;
  const double before = allocated();
  sheet::Sheet sheet = create(std::move(config));
  for (int tick = 0; tick < ticks; ++tick) sheet.step({});
  return (allocated() - before) / sheet.mesh().num_vertices();
}

void print_self_contact() {
  std::printf("\n| scene | ticks | vertices | with self-contact | without |\n|---|---|---|---|---|\n");
  const struct {
    const char* name;
    scene::SheetConfig (*make)();
    int ticks;
  } rows[] = {{"hung by a corner, nothing near", [] { return scenes::hung_by_corner(); }, 2},
              {"falls on its edge", [] { return scenes::falls_on_edge(); }, 45},
              {"falls in five strips", [] { return scenes::falls_in_strips(); }, 30},
              {"thrown on a layer", [] { return scenes::thrown_on_a_layer(); }, 30},
              {"stack of ten", [] { return scenes::stack_of_ten(); }, 15}};
  for (const auto& row : rows) {
    const double with = held(row.make(), true, row.ticks), without = held(row.make(), false, row.ticks);
    std::printf("| %s | %d | %d | %.0f | %.0f |\n", row.name, row.ticks, create(row.make()).mesh().num_vertices(), with,
                without);
    std::fflush(stdout);
  }
}

void print_sleep(int num_sheets) {
  constexpr int kSide = 4;
  constexpr double kWatched = 20.0;  // s
  host::RealClock clock;
  host::SystemEntropy entropy;
  host::HostOptions options;
  options.max_sheets = num_sheets;
  options.max_load = 0.0;  // until they sleep they need more than there is
  host::Host host(options, clock, entropy);
  const double before = allocated();
  scene::SheetConfig still = scenes::hanging(kSide);
  still.gravity.setZero();
  for (int i = 0; i < num_sheets; ++i) {
    host.create_sheet("s" + std::to_string(i), still, false,
                      [](const auto& made) { KERF_CHECK(made.ok(), "the benchmark's sheet is refused"); });
  }
  while (host.metrics().sleeping_sheets < num_sheets) std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const double used = allocated() - before;
  const std::int64_t ticks = host.metrics().ticks;
  const double cpu = process_cpu_s();
  std::this_thread::sleep_for(std::chrono::duration<double>(kWatched));
  const double spent = process_cpu_s() - cpu;
  std::printf(
      "\n%d sheets of %d vertices asleep for %.0f s: %.2f ms of CPU time, %.5f %% of a core; %lld ticks; %.1f kB a "
      "sheet\n",
      num_sheets, kSide * kSide, kWatched, 1e3 * spent, 100.0 * spent / kWatched,
      static_cast<long long>(host.metrics().ticks - ticks), 1e-3 * used / num_sheets);
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  kerf::bench::print_memory();
  kerf::bench::print_self_contact();
  const int num_sheets = argc > 1 ? std::atoi(argv[1]) : 10'000;
  if (num_sheets > 0) kerf::bench::print_sleep(num_sheets);
}
