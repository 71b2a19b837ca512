// Compares what a tick is estimated to take, from counts alone, with what ticks take.
//   tick_estimate_bench [SCENE...]     parts of scenes' names
// Each sheet is stepped for a while, cut, and stepped on. Times are CPU times of a tick of 1/60 s, estimates those of
// the sheet before each of them: medians of 21 ticks. The first row is measured again at the end: how much the machine
// itself changes meanwhile.
#include <cstdio>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/check.h"
#include "server/core/fem/model/tick_cost.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/random_cuts_scene.h"
#include "tests/bench/scenes.h"
#include "tests/support/self_contact_scenes.h"

namespace kerf::bench {
namespace {

constexpr int kTimedTicks = 21;

struct Scene {
  std::string name;
  std::function<sheet::Sheet()> make;
  int ticks = 0;  // before it is cut
  int cuts = 0;
};

fem::Material preset(std::string_view name) {
  return fem::find_preset(name).value();
}

sheet::Sheet hung(int side, std::string_view material, scene::IntegratorKind kind, double wind = 0.0) {
  scene::SheetConfig config = horizontal_cloth(side, kind);
  config.material = preset(material);
  config.integrator.max_substeps = 100'000;
  config.pins.emplace_back(scene::RegionEdge::kTop);
  if (wind > 0.0) config.wind = {{0.0, wind, 0.0}, 1.2, 1.0};
  return create(std::move(config));
}

sheet::Sheet touching(scene::SheetConfig config) {
  config.self_contact.is_on = true;
  return create(std::move(config));
}

sheet::Sheet hung_with_self_contact(scene::IntegratorKind kind) {
  scene::SheetConfig config = horizontal_cloth(50, kind);
  config.pins.emplace_back(scene::RegionEdge::kTop);
  return touching(std::move(config));
}

std::vector<Scene> scenes() {
  const auto explicit_steps = scene::IntegratorKind::kExplicitLeapfrog;
  const auto automatic = scene::IntegratorKind::kAutomatic;
  const auto on_ball = [](std::string_view material) {
    return [material] { return cloth_to_cut(preset(material), CutScene::kBall); };
  };
  return {
      {"demo, hung", [=] { return hung(50, "demo", explicit_steps); }, 20, 0},
      {"demo, hung, 25 x 25", [=] { return hung(25, "demo", explicit_steps); }, 20, 0},
      {"demo, hung, 100 x 100", [=] { return hung(100, "demo", explicit_steps); }, 20, 0},
      {"demo, hung, 1 cut", [=] { return hung(50, "demo", explicit_steps); }, 20, 1},
      {"demo, hung, 10 cuts", [=] { return hung(50, "demo", explicit_steps); }, 20, 10},
      {"demo, hung, 50 cuts", [=] { return hung(50, "demo", explicit_steps); }, 20, 50},
      {"demo, on a ball", on_ball("demo"), 60, 0},
      {"demo, on a ball, 10 cuts", on_ball("demo"), 60, 10},
      {"silk, on a ball", on_ball("silk"), 60, 0},
      {"cotton, hung, 10 cuts", [=] { return hung(50, "cotton", explicit_steps); }, 10, 10},
      {"wool, hung, 50 cuts, automatic", [=] { return hung(50, "wool", automatic); }, 10, 50},
      {"demo, hung, in wind", [=] { return hung(50, "demo", explicit_steps, 2.0); }, 20, 0},
      {"demo, hung, self-contact", [=] { return hung_with_self_contact(automatic); }, 20, 0},
      {"demo, hung, TR-BDF2, self-contact", [=] { return hung_with_self_contact(scene::IntegratorKind::kTrBdf2); }, 20,
       0},
      {"falls on its edge, self-contact", [] { return touching(scenes::falls_on_edge()); }, 20, 0},
      {"thrown on a layer, self-contact", [] { return touching(scenes::thrown_on_a_layer()); }, 20, 0},
      {"demo, hung, TR-BDF2", [=] { return hung(50, "demo", scene::IntegratorKind::kTrBdf2); }, 20, 0},
  };
}

void measure(const Scene& scene) {
  sheet::Sheet sheet = scene.make();
  for (int i = 0; i < scene.ticks; ++i) sheet.step({});
  RandomCutter cutter(kPiSeeds[0]);
  for (int i = 0; i < scene.cuts; ++i) cutter.cut(sheet);
  sheet.step({});  // counts what bodies and loads ask for after the cuts
  fem::TickCost cost;
  std::vector<double> ticks, estimates;
  for (int i = 0; i < kTimedTicks; ++i) {
    cost = sheet.expected_cost();
    estimates.push_back(cost.total());
    const double before = process_cpu_s();
    KERF_CHECK(sheet.step({}).advanced, "no step is refused");
    ticks.push_back(process_cpu_s() - before);
  }
  const double measured_ms = 1e3 * median_of(ticks);
  const double estimated_ms = 1e-6 * median_of(estimates);
  std::string parts;
  for (std::size_t i = 0; i < cost.ns.size(); ++i) {
    const int share = static_cast<int>(100.0 * cost.ns[i] / cost.total() + 0.5);
    if (share > 0) parts += " " + std::string(fem::kTickPartNames[i]) + " " + std::to_string(share);
  }
  std::printf("| %s | %.0f | %.3g | %.3g | %.2f |%s |\n", scene.name.c_str(), cost.substeps, estimated_ms, measured_ms,
              estimated_ms / measured_ms, parts.c_str());
  std::fflush(stdout);
}

int main_of(int argc, char** argv) {
  std::vector<Scene> all = scenes();
  all.push_back(all.front());
  std::puts("| scene | substeps | estimated, ms | measured, ms | ratio | parts, % |\n|---|---|---|---|---|---|");
  for (const Scene& scene : all) {
    bool is_wanted = argc == 1;
    for (int i = 1; i < argc; ++i) is_wanted = is_wanted || scene.name.find(argv[i]) != std::string::npos;
    if (is_wanted) measure(scene);
  }
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  return kerf::bench::main_of(argc, argv);
}
