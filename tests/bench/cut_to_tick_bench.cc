#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "server/base/check.h"
#include "server/core/mesh/triangle_mesh.h"
#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"
#include "tests/bench/stage_clock.h"
#include "tests/support/cut_patterns.h"

// From a cut to the end of the tick that it is made in: the sheet of "The race" with 20 kirigami slits.
namespace kerf::bench {
namespace {

struct Setting {
  const char* name;
  scene::IntegratorKind integrator;
  scene::Precision precision;
};

constexpr Setting kSettings[] = {
    {"explicit", scene::IntegratorKind::kExplicitLeapfrog, scene::Precision::kDouble},
    {"mixed", scene::IntegratorKind::kExplicitLeapfrog, scene::Precision::kMixed},
    {"implicit", scene::IntegratorKind::kImplicitEuler, scene::Precision::kDouble},
};

constexpr int kTicksBefore = 10;
constexpr int kBatches = 11;

std::vector<scene::Cut> slits() {
  std::vector<scene::Cut> cuts;
  for (const cut::Curve& curve : test::kirigami(5, 4)) cuts.emplace_back().curve = curve;
  return cuts;
}

struct Times {
  std::vector<double> cut, update, tick;  // s
  std::map<std::string, double> phases;   // of cut and update, s, summed over ticks
};

// One tick, with the command or without.
void step(sheet::Sheet& sheet, std::span<const scene::Command> commands, Times& times) {
  StageClock clock;
  const sheet::TickReport report = sheet.step(commands, &clock);
  for (const Result<scene::CommandReply>& reply : report.replies) {
    KERF_CHECK(reply.ok(), "the benchmark's cut is refused");
  }
  times.cut.push_back(clock.spent(sheet::Stage::kCut));
  times.update.push_back(clock.spent(sheet::Stage::kModelUpdate));
  for (const auto& [phase, spent] : clock.phases()) times.phases[phase] += spent;
  times.tick.push_back(clock.spent(sheet::Stage::kLoads) + clock.spent(sheet::Stage::kIntegrate));
}

double mean_us(const std::vector<double>& seconds) {
  double sum = 0.0;
  for (const double s : seconds) sum += s;
  return 1e6 * sum / static_cast<double>(seconds.size());
}

double worst_us(const std::vector<double>& seconds) {
  return 1e6 * *std::max_element(seconds.begin(), seconds.end());
}

void report(benchmark::State& state, const Times& before, const Times& times) {
  state.counters["tick_before_us"] = mean_us(before.tick);
  for (const auto& [name, spent] : {std::pair("cut", &times.cut), {"update", &times.update}, {"tick", &times.tick}}) {
    state.counters[std::string(name) + "_us"] = mean_us(*spent);
    state.counters[std::string(name) + "_worst_us"] = worst_us(*spent);
  }
  for (const auto& [phase, spent] : times.phases) {
    state.counters[phase] = 1e6 * spent / static_cast<double>(times.update.size());
  }
}

sheet::Sheet swinging(const Setting& setting, Times& before) {
  sheet::Sheet sheet = race_cloth(50, setting.integrator, setting.precision);
  for (int tick = 0; tick < kTicksBefore; ++tick) step(sheet, {}, before);
  return sheet;
}

// A slit a tick.
void cut_each_tick(benchmark::State& state, const std::string& name, const Setting& setting) {
  Times before;
  Times times;
  sheet::Sheet sheet = swinging(setting, before);
  const int vertices = sheet.mesh().num_vertices();
  const std::vector<scene::Cut> cuts = slits();
  std::size_t next = 0;
  for (auto _ : state) {
    const scene::Command command = cuts.at(next++);
    step(sheet, {&command, 1}, times);
    state.SetIterationTime(times.cut.back() + times.update.back() + times.tick.back());
  }
  state.counters["new_vertices"] = sheet.mesh().num_vertices() - vertices;
  report(state, before, times);
  expect_hash(state, name, sheet.state_hash());
}

// All slits in one tick, taken back between.
void cut_at_once(benchmark::State& state, const std::string& name, const Setting& setting) {
  Times before;
  Times times;
  sheet::Sheet sheet = swinging(setting, before);
  const int vertices = sheet.mesh().num_vertices();
  const scene::Command batch = scene::CutBatch{slits()};
  const scene::Command undo = scene::UndoCut{};
  for (auto _ : state) {
    step(sheet, {&batch, 1}, times);
    state.SetIterationTime(times.cut.back() + times.update.back() + times.tick.back());
    state.counters["new_vertices"] = sheet.mesh().num_vertices() - vertices;
    KERF_CHECK(sheet.apply({&undo, 1}).replies[0].ok(), "the cut cannot be undone");
  }
  report(state, before, times);
  expect_hash(state, name, sheet.state_hash());
}

const bool kCutToTickRegistered = [] {
  for (const Setting& setting : kSettings) {
    const std::string each = std::string("cut_to_tick/") + setting.name + "/2500";
    benchmark::RegisterBenchmark(each.c_str(), [=](benchmark::State& state) { cut_each_tick(state, each, setting); })
        ->Iterations(static_cast<std::int64_t>(slits().size()))
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
    const std::string once = std::string("cut_batch_to_tick/") + setting.name + "/2500";
    benchmark::RegisterBenchmark(once.c_str(), [=](benchmark::State& state) { cut_at_once(state, once, setting); })
        ->Iterations(kBatches)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench
