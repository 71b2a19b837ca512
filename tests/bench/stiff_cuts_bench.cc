// Measures how fast stiff sheets are stepped at rest, and before, in and after the tick that cuts them. Each is run as
// it is and softened by Fidelity::kRealTime.
//   stiff_cuts_bench [MATERIAL [SCENE...]]   such as wool flower; parts of scenes' names
// Frames a second are one over the CPU time of a tick of 1/60 s, all stages of Sheet::step. Before: the mean of 10
// ticks. Cut: the tick with the cut. After: the mean of the 60 ticks that follow, and the slowest of them. At rest: the
// mean of 10 ticks of the uncut sheet, which hangs. The sheet of 1 m x 1 m is level at first, held by its upper edge.
#include <algorithm>
#include <cstdio>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/check.h"
#include "server/core/fem/step/softening.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/scenes.h"
#include "tests/support/cut_patterns.h"

namespace kerf::bench {
namespace {

struct Scene {
  std::string name;
  int side = 0;  // vertices
  std::vector<cut::Curve> curves;
};

struct Way {
  const char* name;
  scene::IntegratorKind integrator;
  scene::Fidelity fidelity;
};

constexpr Way kWays[] = {
    {"exact, explicit", scene::IntegratorKind::kExplicitLeapfrog, scene::Fidelity::kExact},
    {"exact, automatic", scene::IntegratorKind::kAutomatic, scene::Fidelity::kExact},
    {"real-time, explicit", scene::IntegratorKind::kExplicitLeapfrog, scene::Fidelity::kRealTime},
    {"real-time, automatic", scene::IntegratorKind::kAutomatic, scene::Fidelity::kRealTime},
};

std::vector<Scene> scenes() {
  const cut::CubicBezier across{{{0.2, 0.3}, {0.4, 0.5}, {0.6, 0.2}, {0.8, 0.4}}};
  const cut::CubicBezier along{{{0.45, 0.1}, {0.6, 0.3}, {0.4, 0.5}, {0.55, 0.7}}};
  std::vector<Scene> all;
  for (const int side : {15, 50}) {
    const std::string size = ", " + std::to_string(side) + "x" + std::to_string(side);
    all.push_back({"single" + size, side, {across}});
    all.push_back({"intersecting" + size, side, {across, along}});
    all.push_back({"punch" + size, side, {cut::Circle{{0.5037, 0.4971}, 0.15}}});
  }
  for (test::CutPattern& pattern : test::cut_patterns(1.0 / 49)) {
    if (pattern.name.starts_with("flower") || pattern.name.ends_with("slits")) {
      all.push_back({pattern.name + ", 50x50", 50, std::move(pattern.curves)});
    }
  }
  return all;
}

sheet::Sheet make(const Scene& scene, const Way& way, const fem::Material& material, bool hangs) {
  scene::SheetConfig config = horizontal_cloth(scene.side, way.integrator);
  config.material = material;
  config.fidelity = way.fidelity;
  config.integrator.max_substeps = 100'000;
  config.pins.emplace_back(scene::RegionEdge::kTop);
  if (hangs) {
    config.placement.y_axis = {0.0, 0.0, 1.0};
    config.material.mass_damping = 8.0;
  }
  return create(std::move(config));
}

double tick_s(sheet::Sheet& sheet, const std::vector<scene::Command>& commands) {
  const double before = process_cpu_s();
  const sheet::TickReport report = sheet.step(commands);
  const double spent = process_cpu_s() - before;
  for (const Result<scene::CommandReply>& reply : report.replies) KERF_CHECK(reply.ok(), "a cut is refused");
  return spent;
}

std::vector<double> ticks_s(sheet::Sheet& sheet, int count) {
  std::vector<double> spent;
  for (int i = 0; i < count; ++i) spent.push_back(tick_s(sheet, {}));
  return spent;
}

double frames_a_second(const std::vector<double>& ticks) {
  return static_cast<double>(ticks.size()) / std::accumulate(ticks.begin(), ticks.end(), 0.0);
}

void measure(const Scene& scene, const Way& way, const fem::Material& material) {
  sheet::Sheet sheet = make(scene, way, material, false);
  const double before = frames_a_second(ticks_s(sheet, 10));
  std::vector<scene::Command> cuts;
  for (const cut::Curve& curve : scene.curves) {
    scene::Cut cut;
    cut.curve = curve;
    cuts.emplace_back(cut);
  }
  const double during = 1.0 / tick_s(sheet, cuts);
  const std::vector<double> after = ticks_s(sheet, 60);
  sheet::Sheet hanging = make(scene, way, material, true);
  ticks_s(hanging, 60);
  const double softened = sheet.softening() ? sheet.softening()->factor : 1.0;
  std::printf("| %s | %s | %.0f | %.1f | %.1f | %.1f, %.1f | %.1f |\n", scene.name.c_str(), way.name, softened, before,
              during, frames_a_second(after), 1.0 / *std::max_element(after.begin(), after.end()),
              frames_a_second(ticks_s(hanging, 10)));
  std::fflush(stdout);
}

int main_of(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "wool";
  const Result<fem::Material> material = fem::find_preset(name);
  if (!material.ok()) {
    std::fprintf(stderr, "stiff_cuts_bench: %s\n", material.error().message.c_str());
    return 2;
  }
  const auto is_wanted = [&](const Scene& scene) {
    return argc < 3 || std::any_of(argv + 2, argv + argc,
                                   [&](const char* part) { return scene.name.find(part) != std::string::npos; });
  };
  std::printf("%s, frames a second\n| scene | way | softened | before | cut | after: mean, lowest | at rest |\n",
              name.c_str());
  std::printf("|---|---|---|---|---|---|---|\n");
  for (const Scene& scene : scenes()) {
    for (const Way& way : kWays) {
      if (is_wanted(scene)) measure(scene, way, *material);
    }
  }
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  return kerf::bench::main_of(argc, argv);
}
