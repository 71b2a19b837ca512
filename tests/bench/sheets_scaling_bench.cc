#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "server/base/check.h"
#include "server/service/host/entropy.h"
#include "server/service/host/host.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/expected.h"
#include "tests/bench/scenes.h"

// Measures the gain of a second thread: the same sheets in a host with one worker and in one with two, by turns.
namespace kerf::bench {
namespace {

constexpr int kScalingRounds = 5;

struct ScalingCase {
  int sheets;
  int side;   // vertices
  int ticks;  // a round
};

// Gravity differs, so that no sheet moves as another.
scene::SheetConfig cloth(int side, int i) {
  scene::SheetConfig config = swinging_cloth(side, scene::IntegratorKind::kExplicitLeapfrog).config();
  config.gravity.z() -= 0.01 * i;
  return config;
}

struct Spent {
  double wall_s = 0.0;
  double cpu_s = 0.0;
};

// Paused sheets in a host of so many workers.
class PausedSheets {
 public:
  PausedSheets(const ScalingCase& scene, std::int32_t workers)
      : scene_(scene), host_(options(scene, workers), clock_, entropy_) {
    for (int i = 0; i < scene_.sheets; ++i) host_.create_sheet(id(i), cloth(scene_.side, i), true, must_do);
    host_.wait_idle();
  }

  // All of them, as fast as the workers can.
  void step(Spent& sum) {
    const double cpu = process_cpu_s();
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < scene_.sheets; ++i) host_.step(id(i), scene_.ticks, must_do);
    host_.wait_idle();
    sum.wall_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    sum.cpu_s += process_cpu_s() - cpu;
  }

  std::vector<std::uint64_t> hashes() {
    std::vector<std::uint64_t> all(static_cast<std::size_t>(scene_.sheets));
    for (int i = 0; i < scene_.sheets; ++i) {
      host_.inspect(
          id(i), [&hash = all[static_cast<std::size_t>(i)]](const sheet::Sheet& sheet) { hash = sheet.state_hash(); },
          [](const Result<Nothing>& done) { KERF_CHECK(done.ok(), "a sheet is gone"); });
    }
    host_.wait_idle();
    return all;
  }

 private:
  static std::string id(int i) { return "s" + std::to_string(i); }
  static void must_do(const Result<host::SheetStatus>& done) {
    KERF_CHECK(done.ok(), "the host refuses a benchmark's sheet");
  }
  static host::HostOptions options(const ScalingCase& scene, std::int32_t workers) {
    host::HostOptions options;
    options.workers = workers;
    options.long_work = host::Nanoseconds(0);  // so many, whatever a turn takes
    options.max_sheets = scene.sheets;
    return options;
  }

  ScalingCase scene_;
  host::RealClock clock_;
  host::SystemEntropy entropy_;
  host::Host host_;
};

// Returns the hashes without any host.
std::vector<std::uint64_t> hashes_alone(const ScalingCase& scene) {
  std::vector<std::uint64_t> all;
  for (int i = 0; i < scene.sheets; ++i) {
    sheet::Sheet sheet = sheet::Sheet::create(cloth(scene.side, i)).value();
    for (int tick = 0; tick < kScalingRounds * scene.ticks; ++tick) sheet.step({});
    all.push_back(sheet.state_hash());
  }
  return all;
}

// FNV-1a, of 64-bit words.
std::uint64_t combined(const std::vector<std::uint64_t>& hashes) {
  std::uint64_t all = 14695981039346656037ULL;
  for (const std::uint64_t hash : hashes) all = (all ^ hash) * 1099511628211ULL;
  return all;
}

void scaling(benchmark::State& state, const std::string& name, const ScalingCase& scene) {
  PausedSheets one(scene, 1);
  PausedSheets two(scene, 2);
  Spent with_one;
  Spent with_two;
  for (auto _ : state) {
    one.step(with_one);
    const double before = with_two.wall_s;
    two.step(with_two);
    state.SetIterationTime(with_two.wall_s - before);
  }
  const double ticks = static_cast<double>(kScalingRounds) * scene.ticks * scene.sheets;
  state.counters["wall_1_us"] = 1e6 * with_one.wall_s / ticks;
  state.counters["wall_2_us"] = 1e6 * with_two.wall_s / ticks;
  state.counters["speedup"] = with_one.wall_s / with_two.wall_s;
  state.counters["cpu_ratio"] = with_two.cpu_s / with_one.cpu_s;
  state.counters["cores_1"] = with_one.cpu_s / with_one.wall_s;
  state.counters["cores_2"] = with_two.cpu_s / with_two.wall_s;
  const std::vector<std::uint64_t> alone = hashes_alone(scene);
  if (one.hashes() != alone || two.hashes() != alone) state.SkipWithError("sheets differ with the number of workers");
  expect_hash(state, name, combined(alone));
}

const bool kSheetsScalingRegistered = [] {
  for (const ScalingCase& scene :
       {ScalingCase{1, 100, 4}, ScalingCase{2, 15, 400}, ScalingCase{2, 50, 40}, ScalingCase{2, 100, 8},
        ScalingCase{2, 200, 2}, ScalingCase{8, 50, 10}, ScalingCase{64, 15, 40}}) {
    const std::string name =
        "sheets_scaling/" + std::to_string(scene.sheets) + "/" + std::to_string(scene.side * scene.side);
    benchmark::RegisterBenchmark(name.c_str(), [name, scene](benchmark::State& state) { scaling(state, name, scene); })
        ->Iterations(kScalingRounds)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench
