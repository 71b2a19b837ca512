// The tables of tests/bench/notes/time-integration.md: how far each integrator is from a fine reference, for how many
// linear solves.
//   time_error_bench [wool|soft]
#include <cstdio>
#include <string_view>
#include <vector>

#include "tests/support/falling_sheet.h"

namespace kerf::bench {
namespace {

constexpr double kInterval = 0.125;  // s, between comparisons
constexpr int kIntervals = 4;
constexpr int kDefault = -1;

struct Scheme {
  const char* name;
  fem::IntegratorKind kind;
  int rate;        // Hz, of steps
  int iterations;  // Newton's, of a solve; 0: until it has converged; kDefault: five at most
};

void report(const char* name, const test::FallingSheet& scene, const test::Fall& tested, const test::Fall& reference) {
  constexpr double kDuration = kInterval * kIntervals;
  std::printf("| %s | %.0f | %.0f |", name, tested.solves / kDuration, 1e3 * tested.seconds / kDuration);
  for (std::size_t k = 0; k < kIntervals; ++k) {
    const double error = test::largest_distance(tested.states[k], reference.states[k]);
    std::printf("%s%.3g", k == 0 ? " " : " / ", 1e3 * error);
  }
  std::printf(" | %+.2g | %d |\n", scene.energy_gain(tested.states.back()), tested.repaired);
}

test::Fall run(const test::FallingSheet& scene, const fem::IntegratorOptions& options, int rate) {
  return test::fall(scene, options, rate, kInterval, kIntervals);
}

fem::IntegratorOptions explicit_options(double cfl, double damping) {
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kExplicit;
  options.cfl = cfl;
  options.precision = fem::Precision::kDouble;
  options.highest_mode_damping = damping;
  return options;
}

std::vector<Scheme> schemes() {
  using fem::IntegratorKind;
  return {
      {"IE 64, converged", IntegratorKind::kImplicitEuler, 64, 0},
      {"IE 64, default", IntegratorKind::kImplicitEuler, 64, kDefault},
      {"IE 64, 1", IntegratorKind::kImplicitEuler, 64, 1},
      {"IE 64, 2", IntegratorKind::kImplicitEuler, 64, 2},
      {"IE 240, converged", IntegratorKind::kImplicitEuler, 240, 0},
      {"IE 240, 1", IntegratorKind::kImplicitEuler, 240, 1},
      {"IE 240, 2", IntegratorKind::kImplicitEuler, 240, 2},
      {"IE 960, 1", IntegratorKind::kImplicitEuler, 960, 1},
      {"IE 960, 2", IntegratorKind::kImplicitEuler, 960, 2},
      {"BDF2 256, 2", IntegratorKind::kBdf2, 64, 2},
      {"BDF2 256, 4", IntegratorKind::kBdf2, 64, 4},
      {"BDF2 480, 2", IntegratorKind::kBdf2, 120, 2},
      {"BDF2 960, 1", IntegratorKind::kBdf2, 240, 1},
      {"BDF2 960, 2", IntegratorKind::kBdf2, 240, 2},
      {"TR 960, 1", IntegratorKind::kTrapezoidal, 960, 1},
      {"TR 960, 2", IntegratorKind::kTrapezoidal, 960, 2},
      {"TR-BDF2 64, converged", IntegratorKind::kTrBdf2, 64, 0},
      {"TR-BDF2 64, default", IntegratorKind::kTrBdf2, 64, kDefault},
      {"TR-BDF2 120, 2", IntegratorKind::kTrBdf2, 120, 2},
      {"TR-BDF2 240, 1", IntegratorKind::kTrBdf2, 240, 1},
      {"TR-BDF2 240, 2", IntegratorKind::kTrBdf2, 240, 2},
      {"TR-BDF2 480, 1", IntegratorKind::kTrBdf2, 480, 1},
      {"TR-BDF2 480, 2", IntegratorKind::kTrBdf2, 480, 2},
  };
}

void measure(const char* name, const fem::Material& material) {
  const test::FallingSheet scene(material);
  std::printf("%s\n| scheme | solves a s | CPU ms a s | error mm | E - E0 J | repaired |\n|---|---|---|---|---|---|\n",
              name);
  const test::Fall reference = run(scene, explicit_options(0.05, 0.0), 240);
  report("explicit, a fifth of it (reference 1/20)", scene, run(scene, explicit_options(0.2, 0.0), 240), reference);
  report("explicit, default but in double", scene, run(scene, explicit_options(fem::IntegratorOptions{}.cfl, 0.05), 64),
         reference);
  for (const Scheme& scheme : schemes()) {
    fem::IntegratorOptions options;
    options.kind = scheme.kind;
    options.linear_solver = linear::LinearSolverKind::kDirect;
    if (scheme.iterations != kDefault) {
      options.newton_iterations = scheme.iterations > 0 ? scheme.iterations : 50;
      options.newton_tolerance = scheme.iterations > 0 ? 1e-12 : 1e-8;
    }
    report(scheme.name, scene, run(scene, options, scheme.rate), reference);
  }
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  const std::string_view only = argc > 1 ? argv[1] : "";
  if (only != "soft") kerf::bench::measure("wool", kerf::fem::find_preset("wool").value());
  if (only != "wool") kerf::bench::measure("soft", kerf::fem::isotropic(1.0e6, 0.3, 5.0e-4, 1000.0));
  return 0;
}
