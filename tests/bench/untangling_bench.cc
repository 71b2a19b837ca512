// Sheets that pass through themselves: how many pairs of triangles still do, over time.
//   untangling_bench [SECONDS [INTEGRATOR [START]]]
// SECONDS: of motion after the start, 2 without. INTEGRATOR: explicit (the default) or tr-bdf2. START: only the starts
// whose names begin with it. Energy is that gained at most in a tick, and the largest speed over that before.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/core/contact/intersections.h"
#include "server/core/fem/element/state.h"
#include "server/core/sheet/sheet.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/scenes.h"
#include "tests/bench/race_scene.h"
#include "tests/support/self_contact_scenes.h"
#include "tests/support/solid_triangles.h"
#include "tests/support/tangled_scenes.h"

namespace kerf::bench {
namespace {

struct Start {
  std::string name;
  std::function<scene::SheetConfig()> make;
  double without = 0.0;  // s, before self-contact is turned on
};

std::vector<Start> starts() {
  std::vector<Start> all;
  for (const double depth : {0.001, 0.003, 0.01}) {
    const std::string by = std::to_string(static_cast<int>(1e3 * depth + 0.5)) + " mm";
    all.push_back({"poke " + by, [depth] { return scenes::poked_through(depth); }});
    all.push_back({"strip " + by, [depth] { return scenes::pushed_through(depth); }});
    all.push_back({"border " + by, [depth] { return scenes::pushed_through(depth, true); }});
  }
  all.push_back({"half strip", [] { return scenes::pushed_through(0.15); }});
  all.push_back({"half border", [] { return scenes::pushed_through(0.15, true); }});
  all.push_back({"pile 20", [] { return scenes::falls_on_edge(20); }, 2.0});
  all.push_back({"pile 50", [] { return scenes::falls_on_edge(); }, 2.0});
  all.push_back({"early pile 50", [] { return scenes::falls_on_edge(); }, 0.6});
  return all;
}

double fastest(const sheet::Sheet& sheet) {
  return sheet.state().v.colwise().norm().maxCoeff();
}

void measure(const Start& start, double seconds, scene::IntegratorKind kind) {
  scene::SheetConfig config = start.make();
  config.integrator.kind = kind;
  const auto ticks_before = static_cast<int>(start.without / kTick + 0.5), ticks = static_cast<int>(seconds / kTick + 0.5);
  config.self_contact.is_on = ticks_before == 0;
  sheet::Sheet sheet = create(std::move(config));
  for (int i = 0; i < ticks_before; ++i) sheet.step({});
  const auto count = [&] {
    return static_cast<long>(contact::IntersectionSearch().count(test::solid_triangles(sheet.mesh()), sheet.state().x));
  };
  std::printf("| %s | %ld |", start.name.c_str(), count());
  scene::SetSelfContact on;
  on.is_on = true;
  std::vector<scene::Command> commands;
  if (ticks_before > 0) commands.emplace_back(on);
  double energy = sheet.energies().total(), speed = fastest(sheet), gain = -1e9, faster = -1e9, most_ms = 0.0, ms = 0.0;
  const double first = energy;
  for (int i = 0; i < ticks; ++i) {
    const double before = thread_cpu_s();
    sheet.step(std::exchange(commands, {}));
    const double of_tick = 1e3 * (thread_cpu_s() - before);
    ms += of_tick;
    most_ms = std::max(most_ms, of_tick);
    const double energy_before = std::exchange(energy, sheet.energies().total());
    const double speed_before = std::exchange(speed, fastest(sheet));
    gain = std::max(gain, energy - energy_before);
    faster = std::max(faster, speed - speed_before);
    for (const int at : {1, 3, 6, 12, 30, 60, 120, 300, 600, 1200, 1800}) {
      if (i + 1 == at) std::printf(" %ld |", count());
    }
    std::fflush(stdout);
  }
  std::printf(" %.1e, %.1e | %.3f | %.1f, %.1f |\n", gain, energy - first, faster, ms / ticks, most_ms);
  std::fflush(stdout);
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  using namespace kerf;
  const double seconds = argc > 1 ? std::atof(argv[1]) : 2.0;
  const std::string_view kind = argc > 2 ? argv[2] : "explicit", only = argc > 3 ? argv[3] : "";
  std::printf("| start | pairs | after ticks 1, 3, 6, 12, 30, 60, 120, 300, 600, 1200, 1800 | J in a tick, in all | m/s faster | ms a tick, worst |\n");
  for (const bench::Start& start : bench::starts()) {
    if (!start.name.starts_with(only)) continue;
    bench::measure(start, seconds,
                   kind == "tr-bdf2" ? scene::IntegratorKind::kTrBdf2 : scene::IntegratorKind::kExplicitLeapfrog);
  }
  return 0;
}
