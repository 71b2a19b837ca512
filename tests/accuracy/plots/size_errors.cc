// What ticks of a sheet cost and how far it is off at the end of them, against explicit steps without damping of its
// own mesh. Of these and then of each scene one line of JSON: {vertices, integrator, substeps, solves,
// linear_iterations, ticks_not_converged, ticks_repaired, simulated_s, cpu_s, error_m}.
//   size_errors REFERENCE_CFL SCENE...
// REFERENCE_CFL: of the reference's stable step. SCENE: files as `kerf run` reads them, all of one sheet over one time;
// their commands are done before it begins, and are not timed.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/base/check.h"
#include "server/sheet/sheet.h"
#include "server/wire/scene_codec.h"

namespace kerf::accuracy {
namespace {

constexpr double kEnoughCpu = 0.1;  // s; what takes less is done again
constexpr int kMostRuns = 3;

template <typename T>
T value_or_throw(Result<T> result, const std::string& what) {
  if (!result) throw std::runtime_error(what + ": " + result.error().field + ": " + result.error().message);
  return std::move(result).value();
}

sheet::SheetConfig read_scene(const std::string& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  const auto refuse = [](const std::string& other) {
    return Result<std::string>(invalid_argument("NO_FILES", "this scene names no other file", other));
  };
  return value_or_throw(wire::decode_scene_file(text.str(), refuse), file);
}

double duration(const sheet::SheetConfig& scene) {
  return static_cast<double>(scene.ticks) / scene.tick_rate_hz;
}

// The sheet as it begins: its commands done, at tick 0.
sheet::Sheet begun(sheet::SheetConfig scene, const sheet::IntegratorFactory& make_integrator) {
  std::vector<sheet::Command> commands;
  for (const sheet::ScheduledCommand& scheduled : scene.commands) commands.push_back(scheduled.command);
  scene.commands.clear();
  sheet::Sheet sheet = value_or_throw(sheet::Sheet::create(std::move(scene), make_integrator), "the sheet");
  for (const Result<sheet::CommandReply>& reply : sheet.apply(commands).replies) value_or_throw(reply, "a command");
  return sheet;
}

struct Run {
  fem::State end;
  fem::StepStats sum;  // of the ticks; flags: of any
  int not_converged = 0;
  int repaired = 0;
  double cpu_s = 0.0;
};

Run run(sheet::Sheet sheet) {
  Run done;
  const std::int64_t ticks = sheet.config().ticks;
  const std::clock_t start = std::clock();
  for (std::int64_t i = 0; i < ticks; ++i) {
    const fem::StepStats stats = sheet.step({}).stats;
    done.sum.substeps += stats.substeps;
    done.sum.newton_iterations += stats.newton_iterations;
    done.sum.linear_iterations += stats.linear_iterations;
    done.sum.simulated += stats.simulated;
    if ((stats.flags & fem::kNotConverged) != 0) ++done.not_converged;
    if ((stats.flags & fem::kRepaired) != 0) ++done.repaired;
  }
  done.cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  done.end = sheet.state();
  return done;
}

sheet::Sheet reference(const sheet::SheetConfig& scene, double cfl) {
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

// Of several where they are short the time of the fastest.
Run timed(const sheet::Sheet& sheet) {
  Run done = run(sheet);
  double spent = done.cpu_s;
  for (int runs = 1; runs < kMostRuns && spent < kEnoughCpu; ++runs) {
    const double again = run(sheet).cpu_s;
    spent += again;
    done.cpu_s = std::min(done.cpu_s, again);
  }
  return done;
}

int measure_all(double cfl, const std::vector<std::string>& files) try {
  std::vector<sheet::SheetConfig> scenes;
  for (const std::string& file : files) scenes.push_back(read_scene(file));
  for (const sheet::SheetConfig& scene : scenes) {
    if (std::abs(duration(scene) - duration(scenes[0])) > 1e-9) throw std::runtime_error("scenes of different length");
  }
  const sheet::Sheet fine_sheet = reference(scenes[0], cfl);
  const Run fine = timed(fine_sheet);
  KERF_CHECK(std::abs(fine.sum.simulated - duration(scenes[0])) < 1e-9, "the reference covers its time");
  print(fine_sheet, fine, fine.end);
  for (const sheet::SheetConfig& scene : scenes) {
    const sheet::Sheet sheet = begun(scene, fem::make_integrator);
    print(sheet, timed(sheet), fine.end);
  }
  return 0;
} catch (const std::exception& wrong) {
  std::fprintf(stderr, "size_errors: %s\n", wrong.what());
  return 1;
}

}  // namespace
}  // namespace kerf::accuracy

int main(int argc, char** argv) {
  const double cfl = argc > 2 ? std::atof(argv[1]) : 0.0;
  if (cfl <= 0.0 || cfl > 1.0) {
    std::fprintf(stderr, "size_errors REFERENCE_CFL SCENE...\n");
    return 2;
  }
  return kerf::accuracy::measure_all(cfl, {argv + 2, argv + argc});
}
