// The cost of bodies: ticks of 1/60 s with them and without, by turns in one run.
//   contact_bench [SCENE...]   parts of names
// A scene and its twin without bodies are the same sheet in the same place; medians are of CPU time. The least gap is
// that of any vertex to any body at the end of any tick: below 0 something was missed.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "server/core/contact/collider.h"
#include "server/core/contact/prepared_collider.h"
#include "server/core/fem/element/material.h"
#include "server/core/fem/element/state.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/sheet.h"
#include "tests/bench/cpu_time.h"

namespace kerf::bench {
namespace {

using scene::Command;
using scene::SheetConfig;

SheetConfig cloth(double height) {
  SheetConfig config;
  scene::GridSource grid;
  grid.columns = 50;
  grid.rows = 50;
  config.mesh = grid;
  config.material = fem::find_preset("demo").value();
  config.placement.origin = {-0.5, -0.5, height};
  config.placement.y_axis = {0.0, 1.0, 0.0};
  return config;
}

SheetConfig hung() {
  SheetConfig config = cloth(0.8);
  config.pins.emplace_back(scene::RegionEdge::kTopCorners);
  return config;
}

SheetConfig above_a_floor(double depth) {
  SheetConfig config = hung();
  config.colliders = {{contact::Plane{{0.0, 0.0, -depth}, {0.0, 0.0, 1.0}}, 0.5}};
  return config;
}

SheetConfig drape() {
  SheetConfig config = cloth(0.31);
  config.colliders = {{contact::Sphere{{0.0, 0.0, 0.0}, 0.3}, 0.4}};
  return config;
}

SheetConfig lying() {
  SheetConfig config = cloth(0.001);
  config.colliders = {{contact::Plane{}, 0.5}};
  return config;
}

// As deploy/scenes/demo.json has it.
SheetConfig demo() {
  SheetConfig config = hung();
  config.material.youngs_modulus_1 = config.material.youngs_modulus_2 = 1.5e5;
  config.colliders = {{contact::Sphere{{0.0, -0.05, 0.5}, 0.25}, 0.4}, {contact::Plane{}, 0.5}};
  return config;
}

SheetConfig demo_with_slit() {
  SheetConfig config = demo();
  scene::Cut slit;
  slit.curve = cut::CubicBezier{{{0.42, -0.05}, {0.62, 0.1}, {0.38, 0.24}, {0.55, 0.4}}};
  config.commands.push_back({2, Command{slit}});
  return config;
}

struct Scene {
  const char* name;
  std::function<SheetConfig()> make;
  int ticks;
};

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all{{"floor 50 m below", [] { return above_a_floor(50.0); }, 120},
                                      {"floor 1.3 m below", [] { return above_a_floor(1.3); }, 120},
                                      {"drape", drape, 75},
                                      {"lying on a floor", lying, 120},
                                      {"demo", demo, 300},
                                      {"demo with a slit", demo_with_slit, 300}};
  return all;
}

struct Run {
  sheet::Sheet sheet;
  std::vector<double> ms;
  long substeps = 0;
  std::uint32_t flags = 0;

  explicit Run(SheetConfig config) : sheet(sheet::Sheet::create(std::move(config)).value()) {}
  void tick() {
    const double before = thread_cpu_s();
    const sheet::TickReport report = sheet.step({});
    ms.push_back(1e3 * (thread_cpu_s() - before));
    substeps += report.stats.substeps;
    flags |= report.stats.flags;
  }
  [[nodiscard]] double median() const {
    std::vector<double> sorted = ms;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

double least_gap(const sheet::Sheet& sheet) {
  double least = std::numeric_limits<double>::infinity();
  for (const contact::Collider& collider : sheet.config().colliders) {
    const contact::PreparedCollider prepared(collider);
    for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
      if (!sheet.mesh().has_material(v)) continue;
      least = std::min(least, prepared.query(sheet.state().x.col(v)).distance);
    }
  }
  return least - 0.5 * sheet.config().material.thickness;
}

void race(const Scene& scene) {
  SheetConfig config = scene.make();
  Run with(config);
  config.colliders.clear();
  Run without(std::move(config));
  double gap = std::numeric_limits<double>::infinity();
  for (int i = 0; i < scene.ticks; ++i) {
    with.tick();
    without.tick();
    gap = std::min(gap, least_gap(with.sheet));
  }
  std::printf("| %s | %.2f | %.2f | %.2f | %ld, %ld | %.1e | %x |\n", scene.name, with.median(), without.median(),
              with.median() / without.median(), with.substeps / scene.ticks, without.substeps / scene.ticks, gap,
              with.flags);
  std::fflush(stdout);
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  std::printf("| scene | ms a tick | without bodies | ratio | substeps, without | least gap, m | flags |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  for (const kerf::bench::Scene& scene : kerf::bench::scenes()) {
    bool is_wanted = argc < 2;
    for (int i = 1; i < argc; ++i)
      is_wanted = is_wanted || std::string_view(scene.name).find(argv[i]) != std::string_view::npos;
    if (is_wanted) kerf::bench::race(scene);
  }
  return 0;
}
