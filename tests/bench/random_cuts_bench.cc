#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "server/base/check.h"
#include "server/base/state_hash.h"
#include "server/core/fem/step/automatic_integrator.h"
#include "server/core/fem/step/explicit_integrator.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/integrator_settings.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/expected.h"
#include "tests/bench/random_cuts_scene.h"

// Ticks after random cuts, beside those of the same sheet without cuts.
namespace kerf::bench {
namespace {

constexpr int kCounts[] = {0, 1, 5, 10, 20, 50, 100, 200};
constexpr const char* kMaterials[] = {"demo", "cotton", "skin", "wool", "paper"};

struct Variant {
  const char* suffix;
  CutScene scene;
  bool has_hands;     // a grab and a pin
  int warm_up_ticks;  // until it moves, or lies on the ball
};
constexpr Variant kHung{"", CutScene::kHung, false, 2};
constexpr Variant kVariants[] = {{"/grab_pin", CutScene::kHung, true, 2}, {"/ball", CutScene::kBall, false, 15}};

bool is_stiff(std::string_view material) {
  return material == "wool" || material == "paper";
}

// Fewer where a tick takes ten seconds and more.
int most_cuts(std::string_view material) {
  return is_stiff(material) ? 100 : 200;
}

// Fewer where a tick takes seconds.
int ticks_of(int num_cuts, std::string_view material) {
  if (is_stiff(material)) return num_cuts <= 10 ? 11 : num_cuts <= 50 ? 5 : 3;
  return num_cuts <= 50 ? 25 : 11;
}

bool is_checked(int num_cuts) {
  return num_cuts == 0 || num_cuts == 10 || num_cuts == 50;
}

// Two of the largest cluster that are free, or two inside a sheet that has none.
std::array<mesh::VertexId, 2> vertices_to_hold(const sheet::Sheet& sheet) {
  fem::ExplicitIntegrator planned(scene::integrator_options(sheet.config().integrator, sheet.dt()));
  planned.plan(sheet.model(), false);
  std::vector<mesh::VertexId> free;
  for (const fem::InertiaCluster* cluster : planned.inertia().clusters()) {
    if (cluster->vertices().size() <= free.size()) continue;
    std::vector<mesh::VertexId> found;
    for (const mesh::VertexId v : cluster->vertices()) {
      if (!std::binary_search(sheet.pinned_vertices().begin(), sheet.pinned_vertices().end(), v)) found.push_back(v);
    }
    if (found.size() > free.size()) free = std::move(found);
  }
  if (free.size() < 2) return {25 * 50 + 17, 25 * 50 + 33};
  std::sort(free.begin(), free.end());
  return {free.front(), free.back()};
}

void hold(sheet::Sheet& sheet) {
  const auto [pinned, grabbed] = vertices_to_hold(sheet);
  const std::vector<scene::Command> commands{
      scene::SetPins{{scene::RegionEdge::kTop, std::vector<mesh::VertexId>{pinned}}},
      scene::Grab{"hand", grabbed, {}, 0.0}};
  for (const Result<scene::CommandReply>& reply : sheet.apply(commands).replies) {
    KERF_CHECK(reply.ok(), "the benchmark's grab or pin is refused");
  }
}

struct Run {
  sheet::Sheet sheet;
  std::vector<double> ms;
  int substeps = 0;  // of the last tick
  std::uint32_t flags = 0;
  int ticks_in_double = 0;  // such as those of sheets that became too large for mixed precision

  explicit Run(sheet::Sheet made) : sheet(std::move(made)) {}
  void tick() {
    const double before = thread_cpu_s();
    const sheet::TickReport report = sheet.step({});
    ms.push_back(1e3 * (thread_cpu_s() - before));
    substeps = report.stats.substeps;
    flags |= report.stats.flags;
    if ((report.stats.flags & fem::kWidened) != 0) ++ticks_in_double;
  }
  void start(const Variant& variant) {
    if (variant.has_hands) hold(sheet);
    for (int i = 0; i < variant.warm_up_ticks; ++i) tick();
    ms.clear();
    flags = 0;
    ticks_in_double = 0;
  }
  [[nodiscard]] double ms_a_vertex() const { return median_of(ms) / sheet.mesh().num_vertices(); }
};

// A sheet with cuts, and its twin without any.
struct Pair {
  Run cut, uncut;
  CutTime spent;  // s, of all cuts

  Pair(const fem::Material& material, const Variant& variant, int num_cuts, std::uint64_t seed)
      : cut(cloth_to_cut(material, variant.scene)), uncut(cloth_to_cut(material, variant.scene)) {
    RandomCutter cutter(seed);
    for (int i = 0; i < num_cuts; ++i) {
      const CutTime time = cutter.cut(cut.sheet);
      spent.cut += time.cut;
      spent.update += time.update;
      spent.integrator += time.integrator;
    }
    cut.start(variant);
    uncut.start(variant);
  }
};

bool would_be_explicit(const sheet::Sheet& sheet) {
  scene::IntegratorSettings settings;
  return fem::estimate_tick(sheet.model(), scene::integrator_options(settings, sheet.dt())).is_explicit;
}

void report(benchmark::State& state, int num_cuts, const std::vector<std::unique_ptr<Pair>>& pairs) {
  auto& counters = state.counters;
  const auto mean = [&](const char* counter, const auto& value_of) {
    double sum = 0.0;
    for (const auto& pair : pairs) sum += value_of(*pair);
    counters[counter] = sum / static_cast<double>(pairs.size());
  };
  const auto largest = [&](const char* counter, const auto& value_of) {
    double most = 0.0;
    for (const auto& pair : pairs) most = std::max(most, static_cast<double>(value_of(*pair)));
    counters[counter] = most;
  };
  const auto inertia = [](const Pair& pair) {
    return pair.cut.sheet.local_inertia().value_or(fem::LocalInertiaStats{});
  };
  const auto times_uncut = [](const Pair& pair) { return pair.cut.ms_a_vertex() / pair.uncut.ms_a_vertex(); };
  mean("ms", [](const Pair& pair) { return median_of(pair.cut.ms); });
  mean("uncut_ms", [](const Pair& pair) { return median_of(pair.uncut.ms); });
  mean("times_uncut", times_uncut);
  largest("times_uncut_worst", times_uncut);
  mean("substeps", [](const Pair& pair) { return pair.cut.substeps; });
  mean("uncut_substeps", [](const Pair& pair) { return pair.uncut.substeps; });
  mean("plain_substeps",
       [&](const Pair& pair) { return inertia(pair).clusters > 0 ? inertia(pair).plain_substeps : pair.cut.substeps; });
  mean("vertices", [](const Pair& pair) { return pair.cut.sheet.mesh().num_vertices(); });
  mean("clusters", [&](const Pair& pair) { return inertia(pair).clusters; });
  mean("cluster_vertices", [&](const Pair& pair) { return inertia(pair).vertices; });
  largest("largest", [&](const Pair& pair) { return inertia(pair).largest; });
  mean("automatic_is_explicit", [](const Pair& pair) { return would_be_explicit(pair.cut.sheet) ? 1.0 : 0.0; });
  const double per_cut = 1e6 / std::max(num_cuts, 1);
  mean("cut_us", [&](const Pair& pair) { return per_cut * pair.spent.cut; });
  mean("update_us", [&](const Pair& pair) { return per_cut * pair.spent.update; });
  mean("integrator_us", [&](const Pair& pair) { return per_cut * pair.spent.integrator; });
  std::uint32_t flags = 0;
  for (const auto& pair : pairs) flags |= pair->cut.flags;
  counters["flags"] = flags;
  mean("ticks_in_double", [](const Pair& pair) { return pair.cut.ticks_in_double; });
}

void random_cuts(benchmark::State& state, const std::string& name, const char* material, const Variant& variant,
                 int num_cuts) {
  std::vector<std::unique_ptr<Pair>> pairs;
  for (const std::uint64_t seed : kPiSeeds) {
    pairs.push_back(std::make_unique<Pair>(fem::find_preset(material).value(), variant, num_cuts, seed));
  }
  for (auto _ : state) {
    double spent_ms = 0.0;
    for (const auto& pair : pairs) {
      pair->cut.tick();
      pair->uncut.tick();
      spent_ms += pair->cut.ms.back();
    }
    state.SetIterationTime(1e-3 * spent_ms / static_cast<double>(pairs.size()));
  }
  report(state, num_cuts, pairs);
  if (!is_checked(num_cuts)) return;
  StateHash hash;
  for (const auto& pair : pairs) hash.add(pair->cut.sheet.state_hash());
  expect_hash(state, name, hash.value());
}

void add(const char* material, const Variant& variant, int num_cuts) {
  const std::string name = "random_cuts/" + std::to_string(num_cuts) + "/" + material + variant.suffix;
  const auto run = [=](benchmark::State& state) { random_cuts(state, name, material, variant, num_cuts); };
  benchmark::RegisterBenchmark(name.c_str(), run)
      ->Iterations(ticks_of(num_cuts, material))
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

const bool kRandomCutsRegistered = [] {
  for (const char* material : kMaterials) {
    for (const int num_cuts : kCounts) {
      if (num_cuts <= most_cuts(material)) add(material, kHung, num_cuts);
    }
  }
  for (const Variant& variant : kVariants) {
    for (const int num_cuts : kCounts) add("demo", variant, num_cuts);
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench
