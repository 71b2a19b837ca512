// Sheets that pass through themselves: how many pairs of triangles still do, over time.
//   untangling_bench [SECONDS [INTEGRATOR [START]]]
// SECONDS: of motion after the start, 2 without. INTEGRATOR: explicit (the default) or tr-bdf2. START: only the starts
// whose names begin with it; "cuts" has 200 piles that are cut, which do not run otherwise. Energy is that gained at
// most in a tick and in all. Speeds are by how much the fastest vertex became faster in a tick, at most.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/random.h"
#include "server/core/contact/intersections.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/element/state.h"
#include "server/core/sheet/sheet.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/race_scene.h"
#include "tests/bench/scenes.h"
#include "tests/support/self_contact_scenes.h"
#include "tests/support/solid_triangles.h"
#include "tests/support/tangled_scenes.h"

namespace kerf::bench {
namespace {

struct Start {
  std::string name;
  std::function<scene::SheetConfig()> make;
  // Returns the commands of the first tick that is printed, after those before it.
  std::function<std::vector<scene::Command>(sheet::Sheet&)> prepare = [](sheet::Sheet&) {
    return std::vector<scene::Command>();
  };
};

// A pile of a sheet that fell without self-contact, which is then turned on.
Start pile(std::int32_t side, double seconds) {
  const auto make = [side] {
    scene::SheetConfig config = scenes::falls_on_edge(side);
    config.self_contact.is_on = false;
    return config;
  };
  return {"pile " + std::to_string(side) + ", " + std::to_string(seconds).substr(0, 3) + " s", make,
          [seconds](sheet::Sheet& sheet) {
            for (int i = 0; i < std::lround(seconds / kTick); ++i) sheet.step({});
            scene::SetSelfContact on;
            on.is_on = true;
            return std::vector<scene::Command>{on};
          }};
}

// A strip in a slit, which an undo closes.
Start undo() {
  return {"undo", [] { return scenes::pushed_through(0.15); },
          [](sheet::Sheet& sheet) {
            scene::Cut cut;
            cut.curve = cut::Polyline{{scenes::at_strip(-0.5), scenes::at_strip(1.5)}};
            sheet.step(std::vector<scene::Command>{cut});
            for (int i = 0; i < 30; ++i) sheet.step({});
            return std::vector<scene::Command>{scene::UndoCut{}};
          }};
}

// A pile that is cut three times. Only some seeds leave triangles that pass through each other.
Start cut_pile(int seed) {
  const auto make = [] {
    scene::SheetConfig config = scenes::falls_on_edge(12);
    config.self_contact.is_on = true;
    return config;
  };
  return {"cuts " + std::to_string(seed), make, [seed](sheet::Sheet& sheet) {
            SeededRandom random(static_cast<std::uint64_t>(seed));
            for (int i = 0; i < 45; ++i) sheet.step({});
            std::vector<scene::Command> commands;
            for (int i = 0; i < 3; ++i) {
              cut::Polyline line;
              for (int k = 0; k < 4; ++k) {
                const double x = random.uniform(0.05, 0.95);
                line.points.emplace_back(x, random.uniform(0.05, 0.95));
              }
              scene::Cut cut;
              cut.curve = line;
              commands.emplace_back(cut);
            }
            return commands;
          }};
}

std::vector<Start> starts() {
  std::vector<Start> all;
  for (const int depth : {1, 3, 10}) {
    const std::string by = std::to_string(depth) + " mm";
    all.push_back({"poke " + by, [depth] { return scenes::poked_through(1e-3 * depth); }});
    all.push_back({"strip " + by, [depth] { return scenes::pushed_through(1e-3 * depth); }});
    all.push_back({"border " + by, [depth] { return scenes::pushed_through(1e-3 * depth, true); }});
  }
  all.push_back({"half strip", [] { return scenes::pushed_through(0.15); }});
  all.push_back({"half border", [] { return scenes::pushed_through(0.15, true); }});
  all.push_back(undo());
  all.push_back(pile(12, 1.0));
  all.push_back(pile(20, 2.0));
  all.push_back(pile(50, 0.6));
  all.push_back(pile(50, 2.0));
  return all;
}

double fastest(const sheet::Sheet& sheet) {
  return sheet.state().v.colwise().norm().maxCoeff();
}

void measure(const Start& start, double seconds, scene::IntegratorKind kind) {
  scene::SheetConfig config = start.make();
  config.integrator.kind = kind;
  const int ticks = static_cast<int>(std::lround(seconds / kTick));
  sheet::Sheet sheet = create(std::move(config));
  std::vector<scene::Command> commands = start.prepare(sheet);
  const auto count = [&] {
    return static_cast<long>(contact::IntersectionSearch().count(test::solid_triangles(sheet.mesh()), sheet.state().x));
  };
  std::printf("| %s | %ld |", start.name.c_str(), count());
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
  const std::string_view name = argc > 2 ? argv[2] : "explicit", only = argc > 3 ? argv[3] : "";
  const auto kind = name == "tr-bdf2" ? scene::IntegratorKind::kTrBdf2 : scene::IntegratorKind::kExplicitLeapfrog;
  std::printf(
      "| start | pairs | after ticks 1, 3, 6, 12, 30, 60, 120, 300, 600, 1200, 1800 | J in a tick, in all | m/s faster "
      "| "
      "ms a tick, worst |\n");
  std::vector<bench::Start> starts = bench::starts();
  // Piles that are cut are many, so they must be asked for.
  for (int seed = 100; only.starts_with("cuts") && seed < 300; ++seed) starts.push_back(bench::cut_pile(seed));
  for (const bench::Start& start : starts) {
    if (start.name.starts_with(only)) bench::measure(start, seconds, kind);
  }
  return 0;
}
