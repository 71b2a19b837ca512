// The cost of bodies: ticks of 1/60 s with them and without, by turns in one run. Then that of counting the triangles
// that pass through each other, which must not depend on their order.
//   contact_bench [SCENE...]   parts of names; `counted` selects the second table
// A scene and its twin without bodies are the same sheet in the same place; medians are of CPU time. The least gap is
// that of any vertex to any body at the end of any tick: below 0 something was missed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "server/core/contact/collider.h"
#include "server/core/contact/intersections.h"
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

// A sheet of 50 x 50 vertices, edge first onto a floor, which passes through itself as it falls.
sheet::Sheet falling_on_edge() {
  constexpr double kLean = 0.05;  // rad
  SheetConfig config = cloth(0.0);
  config.placement.origin = {-0.5, 0.0, 0.01};
  config.placement.y_axis = {0.0, std::sin(kLean), std::cos(kLean)};
  config.material = fem::isotropic(2.0e6, 0.3, 5.0e-4, 400.0);
  config.colliders = {{contact::Plane{}, 0.3}};
  config.initial_velocity = scene::InitialVelocity{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.3}, {}};
  return sheet::Sheet::create(std::move(config)).value();
}

// Prints what a count takes, the best of many. Returns false if another order of triangles has another count.
bool count(const char* name, const sheet::Sheet& sheet) {
  constexpr int kRounds = 50;
  std::vector<std::array<mesh::VertexId, 3>> triangles;
  for (mesh::TriangleId t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
    if (sheet.mesh().is_solid(t)) triangles.push_back(sheet.mesh().vertices(t));
  }
  contact::IntersectionSearch search;
  double ms = std::numeric_limits<double>::infinity();
  std::int64_t pairs = 0;
  for (int i = 0; i < kRounds; ++i) {
    const double before = thread_cpu_s();
    pairs = search.count(triangles, sheet.state().x);
    ms = std::min(ms, 1e3 * (thread_cpu_s() - before));
  }
  std::printf("| %s | %zu | %ld | %.3f |\n", name, triangles.size(), static_cast<long>(pairs), ms);
  std::fflush(stdout);
  std::reverse(triangles.begin(), triangles.end());
  return search.count(triangles, sheet.state().x) == pairs;
}

// Returns false if a count was wrong.
bool count_all() {
  std::printf("\n| counted | triangles | pairs | ms |\n|---|---|---|---|\n");
  Run swinging(hung());
  bool is_right = count("flat", swinging.sheet);
  for (int i = 0; i < 30; ++i) swinging.tick();
  is_right = count("hung, after 0.5 s", swinging.sheet) && is_right;
  SheetConfig inclined = cloth(0.0);
  inclined.placement.x_axis = {0.8, 0.36, 0.48};
  inclined.placement.y_axis = {-0.6, 0.48, 0.64};
  is_right = count("flat, inclined", sheet::Sheet::create(std::move(inclined)).value()) && is_right;
  sheet::Sheet crumpled = falling_on_edge();
  for (const char* name : {"crumpled, after 0.5 s", "after 1 s", "after 1.5 s"}) {
    for (int i = 0; i < 30; ++i) crumpled.step({});
    is_right = count(name, crumpled) && is_right;
  }
  if (!is_right) std::printf("the count depends on the order of triangles\n");
  return is_right;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  const auto is_wanted = [&](std::string_view name) {
    return argc < 2 || std::any_of(argv + 1, argv + argc,
                                   [name](const char* part) { return name.find(part) != std::string_view::npos; });
  };
  std::printf("| scene | ms a tick | without bodies | ratio | substeps, without | least gap, m | flags |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  for (const kerf::bench::Scene& scene : kerf::bench::scenes()) {
    if (is_wanted(scene.name)) kerf::bench::race(scene);
  }
  return is_wanted("counted") && !kerf::bench::count_all() ? 1 : 0;
}
