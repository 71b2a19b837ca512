#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "server/base/check.h"
#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"
#include "tests/bench/stage_clock.h"

// Measures the cost of a cut by the number of triangles crossed and by the size of the mesh, and its parts.
namespace kerf::bench {
namespace {

// A curve wholly inside a unit square of side x side vertices that crosses about `crossed` triangles: rows of gentle
// waves, joined by turns.
scene::Cut serpentine(int side, int crossed) {
  constexpr double kCrossedPerEdge = 2.15;  // -; triangles crossed for each edge length of the curve
  const double h = 1.0 / (side - 1);
  const double length = crossed / kCrossedPerEdge * h;
  const double rows = std::ceil(length / 0.96);
  const double width = length / rows;
  const double wave = 0.1 * width;
  const double gap = std::min(20.0 * h, 0.8 / rows);
  const double left = 0.5 - 0.5 * width;
  double y = 0.5 - 0.5 * gap * (rows - 1.0);
  double from = left;
  double to = left + width;
  cut::CubicBezier curve;
  curve.points.emplace_back(from, y);
  for (double row = 0.0; row < rows; ++row) {
    if (row > 0.0) {
      const double out = from + (from > 0.5 ? 1.0 : -1.0) * 0.5 * gap;
      curve.points.emplace_back(out, y);
      curve.points.emplace_back(out, y + gap);
      y += gap;
      curve.points.emplace_back(from, y);
    }
    const double swing = std::min(wave, 0.4 * gap);
    curve.points.emplace_back(from + (to - from) / 3.0, y + swing);
    curve.points.emplace_back(from + (to - from) * 2.0 / 3.0, y - swing);
    curve.points.emplace_back(to, y);
    std::swap(from, to);
  }
  scene::Cut cut;
  cut.curve = curve;
  return cut;
}

// Reads what a large sheet's state would be.
double read_much() {
  static const std::vector<double> much(std::size_t{32} << 20, 1.0);
  return std::accumulate(much.begin(), much.end(), 0.0);
}

struct Case {
  scene::IntegratorKind integrator;
  int side;     // vertices
  int crossed;  // triangles, about
  bool is_cold = false;
};

void scaling(benchmark::State& state, const std::string& name, const Case& scene) {
  const auto [integrator, side, crossed, is_cold] = scene;
  const sheet::Sheet whole = swinging_cloth(side, integrator);
  const scene::Command command = serpentine(side, crossed);
  // A copy has no room to grow; a sheet that lives has been cut before. The hash in the replies reads all of a sheet
  // between two cuts, as its steps would: a large one is in no cache then.
  const double h = 1.0 / (side - 1);
  scene::Cut first;
  first.curve = cut::Circle{{3.3 * h, 3.3 * h}, 2.0 * h};
  const scene::Command warm_up = first;
  std::vector<double> cut_s;
  std::vector<double> update_s;
  std::map<std::string, std::vector<double>> phases_s;
  cut::CutReport report;
  std::uint64_t hash = 0;
  sheet::Sheet sheet = whole;
  KERF_CHECK(sheet.apply({&warm_up, 1}).replies[0].ok(), "the first cut is refused");
  const scene::Command undo = scene::UndoCut{};
  for (auto _ : state) {
    if (is_cold) benchmark::DoNotOptimize(read_much());
    StageClock clock;
    const sheet::TickReport done = sheet.apply({&command, 1}, &clock);
    KERF_CHECK(done.replies.size() == 1 && done.replies[0].ok(), "the benchmark's cut is refused");
    report = done.replies[0]->cut->report;
    hash = done.replies[0]->state_hash;
    KERF_CHECK(sheet.apply({&undo, 1}).replies[0].ok(), "the cut cannot be undone");
    cut_s.push_back(clock.spent(sheet::Stage::kCut));
    update_s.push_back(clock.spent(sheet::Stage::kModelUpdate));
    for (const auto& [phase, spent] : clock.phases()) phases_s[phase].push_back(spent);
    state.SetIterationTime(cut_s.back() + update_s.back());
  }
  const auto median_us = [](std::vector<double>& seconds) {
    std::nth_element(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2), seconds.end());
    return 1e6 * seconds[seconds.size() / 2];
  };
  const double cut_us = median_us(cut_s);
  const double update_us = median_us(update_s);
  state.counters["crossed"] = report.crossed_triangles;
  state.counters["new"] = report.new_triangles;
  state.counters["cut_us"] = cut_us;
  state.counters["update_us"] = update_us;
  for (auto& [phase, spent] : phases_s) state.counters[phase] = median_us(spent);
  state.counters["us/crossed"] = (cut_us + update_us) / report.crossed_triangles;
  expect_hash(state, name, hash);
}

void add(const std::string& family, const Case& scene) {
  const int triangles = 2 * (scene.side - 1) * (scene.side - 1);
  const std::string name = family + "/" + std::to_string(scene.crossed) + "/" + std::to_string(triangles);
  benchmark::RegisterBenchmark(name.c_str(), [name, scene](benchmark::State& state) { scaling(state, name, scene); })
      ->Iterations(11)
      ->UseManualTime()
      ->Unit(benchmark::kMicrosecond);
}

const bool kCutScalingRegistered = [] {
  constexpr auto kExplicit = scene::IntegratorKind::kExplicitLeapfrog;
  constexpr auto kImplicit = scene::IntegratorKind::kImplicitEuler;
  for (const int side : {50, 159, 592}) add("cut_scaling", {kExplicit, side, 100});
  for (const int crossed : {10, 30, 300, 1000, 3000, 10000}) add("cut_scaling", {kExplicit, 592, crossed});
  for (const int side : {50, 159, 592}) add("cut_scaling_cold", {kExplicit, side, 100, true});
  for (const int side : {50, 159}) add("cut_scaling_implicit", {kImplicit, side, 100});
  return true;
}();

}  // namespace
}  // namespace kerf::bench
