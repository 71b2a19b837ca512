// Measures the cost of ticks of a sheet, and its error at the end of them relative to undamped explicit steps of its
// own mesh. Prints one line of JSON for the reference and for each scene: {vertices, integrator, substeps, solves,
// linear_iterations, ticks_not_converged, ticks_repaired, simulated_s, cpu_s, error_m}.
//   size_errors REFERENCE_CFL MOST_CPU_S SCENE...
// REFERENCE_CFL: share of the reference's stable step. MOST_CPU_S: a run ends early after this; the reference does not.
// SCENE: files as `kerf run` reads them, all of one sheet over one time; their commands are done before it begins, and
// are not timed.
//   size_errors --threads SCENE...
// Measures the gain of two threads that step a sheet each, both equal. Prints for each scene {vertices, integrator,
// simulated_s, rounds, one_wall_s, one_cpu_s, two_wall_s, two_cpu_s}: the time of a sheet on one thread, and on two
// that of the slower one.
#include <algorithm>
#include <barrier>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/base/check.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/fem/step/integrator_options.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/sheet.h"
#include "server/service/wire/scene_codec.h"
#include "tests/bench/cpu_time.h"

namespace kerf::accuracy {
namespace {

constexpr double kEnoughCpu = 0.1;  // s; what takes less is done again
constexpr int kMostRuns = 3;
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// Parameters of the comparison of one thread with two.
constexpr double kEnoughWall = 0.05;  // s; what takes less is done several times a round, as threads take time to start
constexpr double kEnoughRounds = 1.5;  // s; rounds are made until they took this, but
constexpr int kFewestRounds = 3;
constexpr int kMostRounds = 9;

template <typename T>
T value_or_throw(Result<T> result, const std::string& what) {
  if (!result.ok()) throw std::runtime_error(what + ": " + result.error().field + ": " + result.error().message);
  return std::move(result).value();
}

scene::SheetConfig read_scene(const std::string& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  const auto refuse = [](const std::string& other) {
    return Result<std::string>(invalid_argument("NO_FILES", "this scene names no other file", other));
  };
  return value_or_throw(wire::decode_scene_file(text.str(), refuse), file);
}

double duration(const scene::SheetConfig& scene) {
  return static_cast<double>(scene.ticks) / scene.tick_rate_hz;
}

// The sheet as it begins: its commands done, at tick 0.
sheet::Sheet begun(scene::SheetConfig scene, const sheet::IntegratorFactory& make_integrator) {
  std::vector<scene::Command> commands;
  for (const scene::ScheduledCommand& scheduled : scene.commands) commands.push_back(scheduled.command);
  scene.commands.clear();
  sheet::Sheet sheet = value_or_throw(sheet::Sheet::create(std::move(scene), make_integrator), "the sheet");
  for (const Result<scene::CommandReply>& reply : sheet.apply(commands).replies) value_or_throw(reply, "a command");
  return sheet;
}

struct Run {
  fem::State end;
  fem::StepStats sum;  // of the ticks; flags: of any
  int not_converged = 0;
  int repaired = 0;
  std::uint64_t hash = 0;  // of the sheet at the end
  double cpu_s = 0.0;      // of this thread
  double wall_s = 0.0;
};

double wall_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Run run(sheet::Sheet sheet, double most_cpu_s) {
  Run done;
  const std::int64_t ticks = sheet.config().ticks;
  const double cpu_start = bench::thread_cpu_s();
  const double wall_start = wall_s();
  for (std::int64_t i = 0; i < ticks && bench::thread_cpu_s() - cpu_start < most_cpu_s; ++i) {
    const fem::StepStats stats = sheet.step({}).stats;
    done.sum.substeps += stats.substeps;
    done.sum.newton_iterations += stats.newton_iterations;
    done.sum.linear_iterations += stats.linear_iterations;
    done.sum.simulated += stats.simulated;
    if ((stats.flags & fem::kNotConverged) != 0) ++done.not_converged;
    if ((stats.flags & fem::kRepaired) != 0) ++done.repaired;
  }
  done.cpu_s = bench::thread_cpu_s() - cpu_start;
  done.wall_s = wall_s() - wall_start;
  done.hash = sheet.state_hash();
  done.end = sheet.state();
  return done;
}

sheet::Sheet reference(const scene::SheetConfig& scene, double cfl) {
  return begun(scene, [cfl](fem::IntegratorOptions options) {
    options.kind = fem::IntegratorKind::kExplicit;
    options.precision = fem::Precision::kDouble;
    options.cfl = cfl;
    options.highest_mode_damping = 0.0;
    options.max_substeps = 100'000'000;
    return fem::make_integrator(options);
  });
}

void print(const sheet::Sheet& sheet, const Run& done, const fem::State& fine) {
  const nlohmann::ordered_json line{
      {"vertices", sheet.mesh().num_vertices()},
      {"integrator", sheet.integrator_description()},
      {"substeps", done.sum.substeps},
      {"solves", done.sum.newton_iterations},
      {"linear_iterations", done.sum.linear_iterations},
      {"ticks_not_converged", done.not_converged},
      {"ticks_repaired", done.repaired},
      {"simulated_s", done.sum.simulated},
      {"cpu_s", done.cpu_s},
      {"error_m", (done.end.x - fine.x).colwise().norm().maxCoeff()},
  };
  std::printf("%s\n", line.dump().c_str());
  std::fflush(stdout);
}

// Returns the fastest of several runs if they are short.
Run timed(const sheet::Sheet& sheet, double most_cpu_s) {
  Run done = run(sheet, most_cpu_s);
  double spent = done.cpu_s;
  for (int runs = 1; runs < kMostRuns && spent < kEnoughCpu; ++runs) {
    const double again = run(sheet, most_cpu_s).cpu_s;
    spent += again;
    done.cpu_s = std::min(done.cpu_s, again);
  }
  return done;
}

int measure_all(double cfl, double most_cpu_s, const std::vector<std::string>& files) try {
  std::vector<scene::SheetConfig> scenes;
  for (const std::string& file : files) scenes.push_back(read_scene(file));
  for (const scene::SheetConfig& scene : scenes) {
    if (std::abs(duration(scene) - duration(scenes[0])) > 1e-9) throw std::runtime_error("scenes of different length");
  }
  const sheet::Sheet fine_sheet = reference(scenes[0], cfl);
  const Run fine = timed(fine_sheet, kUnlimited);
  KERF_CHECK(std::abs(fine.sum.simulated - duration(scenes[0])) < 1e-9, "the reference covers its time");
  print(fine_sheet, fine, fine.end);
  for (const scene::SheetConfig& scene : scenes) {
    const sheet::Sheet sheet = begun(scene, fem::make_integrator);
    print(sheet, timed(sheet, most_cpu_s), fine.end);
  }
  return 0;
} catch (const std::exception& wrong) {
  std::fprintf(stderr, "size_errors: %s\n", wrong.what());
  return 1;
}

// Times of a thread that steps a sheet, s.
struct Spent {
  double wall = kUnlimited;
  double cpu = 0.0;
};

// So many threads at once, each steps copies of the sheet, one after another; what a copy takes, on the slower thread.
// Each must end with this hash.
Spent step_at_once(const sheet::Sheet& sheet, int num_threads, int copies, std::uint64_t hash) {
  std::vector<Spent> spent(static_cast<std::size_t>(num_threads), Spent{0.0, 0.0});
  std::barrier start(num_threads);
  const auto step_copies = [&](Spent& mine) {
    start.arrive_and_wait();
    for (int i = 0; i < copies; ++i) {
      const Run done = run(sheet, kUnlimited);
      KERF_CHECK(done.hash == hash, "a sheet ends as it does alone, bit for bit");
      mine.wall += done.wall_s / copies;
      mine.cpu += done.cpu_s / copies;
    }
  };
  std::vector<std::thread> threads;
  for (Spent& mine : spent) threads.emplace_back(step_copies, std::ref(mine));
  for (std::thread& thread : threads) thread.join();
  return *std::max_element(spent.begin(), spent.end(), [](const Spent& a, const Spent& b) { return a.wall < b.wall; });
}

struct Comparison {
  int rounds = 0;
  Spent one;  // thread; of its fastest round, as other work only ever slows one down
  Spent two;
};

// By turns.
Comparison compare_threads(const sheet::Sheet& sheet, const Run& alone) {
  const int copies = std::max(1, static_cast<int>(std::ceil(kEnoughWall / alone.wall_s)));
  Comparison found;
  const double start = wall_s();
  while (found.rounds < kFewestRounds || (found.rounds < kMostRounds && wall_s() - start < kEnoughRounds)) {
    const Spent one = step_at_once(sheet, 1, copies, alone.hash);
    const Spent two = step_at_once(sheet, 2, copies, alone.hash);
    if (one.wall < found.one.wall) found.one = one;
    if (two.wall < found.two.wall) found.two = two;
    ++found.rounds;
  }
  return found;
}

void print(const sheet::Sheet& sheet, const Run& alone, const Comparison& found) {
  const nlohmann::ordered_json line{
      {"vertices", sheet.mesh().num_vertices()},
      {"integrator", sheet.integrator_description()},
      {"simulated_s", alone.sum.simulated},
      {"rounds", found.rounds},
      {"one_wall_s", found.one.wall},
      {"one_cpu_s", found.one.cpu},
      {"two_wall_s", found.two.wall},
      {"two_cpu_s", found.two.cpu},
  };
  std::printf("%s\n", line.dump().c_str());
  std::fflush(stdout);
}

int compare_threads_of_all(const std::vector<std::string>& files) try {
  for (const std::string& file : files) {
    const sheet::Sheet sheet = begun(read_scene(file), fem::make_integrator);
    const Run alone = run(sheet, kUnlimited);
    print(sheet, alone, compare_threads(sheet, alone));
  }
  return 0;
} catch (const std::exception& wrong) {
  std::fprintf(stderr, "size_errors: %s\n", wrong.what());
  return 1;
}

}  // namespace
}  // namespace kerf::accuracy

int main(int argc, char** argv) {
  if (argc > 2 && std::strcmp(argv[1], "--threads") == 0) {
    return kerf::accuracy::compare_threads_of_all({argv + 2, argv + argc});
  }
  const double cfl = argc > 3 ? std::atof(argv[1]) : 0.0;
  const double most_cpu_s = argc > 3 ? std::atof(argv[2]) : 0.0;
  if (cfl <= 0.0 || cfl > 1.0 || most_cpu_s <= 0.0) {
    std::fprintf(stderr, "size_errors REFERENCE_CFL MOST_CPU_S SCENE... | --threads SCENE...\n");
    return 2;
  }
  return kerf::accuracy::measure_all(cfl, most_cpu_s, {argv + 3, argv + argc});
}
