// Measures the errors of integrators at 0.3 s, before anything crumples, over their step. A sheet of 20 x 20 vertices
// falls from the horizontal. Writes CSV: `error_same_step_m` relative to the same steps solved fully (Newton to 1e-10,
// direct), `error_fine_m` relative to the undamped explicit integrator with a twentieth of its stable step.
//   time_errors soft|wool [--coarsest]
// --coarsest: only the longest steps of each integrator.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "server/base/check.h"
#include "tests/support/falling_sheet.h"

namespace kerf::accuracy {
namespace {

using fem::IntegratorKind;
using linear::LinearSolverKind;

constexpr double kEnd = 0.3;             // s
constexpr double kExplicitRate = 240.0;  // Hz, of ticks, which substeps divide
constexpr double kFineCfl = 0.05;

struct Solving {
  LinearSolverKind solver;
  int newton_iterations;
  double newton_tolerance;
  double linear_tolerance;
};

constexpr double kNever = 1e-14;  // of Newton's: all iterations are made
constexpr Solving kSolved{LinearSolverKind::kDirect, 100, 1e-10, 1e-10};
// A row of the table for each; the first is IntegratorOptions' default.
constexpr Solving kSolvings[] = {
    {LinearSolverKind::kBlockJacobiCg, 5, 1e-4, 1e-4}, {LinearSolverKind::kDirect, 5, 1e-4, 1e-4},
    {LinearSolverKind::kFactorCg, 5, 1e-4, 1e-4},      {LinearSolverKind::kDirect, 2, kNever, 1e-4},
    {LinearSolverKind::kDirect, 1, kNever, 1e-4},
};

struct ImplicitScheme {
  const char* name;
  IntegratorKind kind;
  int substeps;               // of equal length a step
  std::vector<double> rates;  // Hz, of steps; kEnd is a whole number of them
};

std::vector<ImplicitScheme> implicit_schemes() {
  const std::vector<double> rates{30, 60, 120, 240, 480, 960};
  return {{"implicit Euler", IntegratorKind::kImplicitEuler, 1, rates},
          {"TR-BDF2", IntegratorKind::kTrBdf2, 1, rates},
          {"trapezoidal", IntegratorKind::kTrapezoidal, 1, rates},
          {"BDF2", IntegratorKind::kBdf2, fem::kBdf2Substeps, {10, 20, 40, 80, 160, 240}}};
}

struct ExplicitScheme {
  const char* name;
  const char* precision_name;
  fem::Precision precision;
  double damping;
  std::vector<double> cfls;
};

std::vector<ExplicitScheme> explicit_schemes() {
  return {{"explicit", "double", fem::Precision::kDouble, 0.05, {0.95, 0.6, 0.4, 0.2}},
          {"explicit", "mixed", fem::Precision::kMixed, 0.05, {0.95, 0.6, 0.4, 0.2}},
          {"explicit undamped", "double", fem::Precision::kDouble, 0.0, {0.7, 0.6, 0.4, 0.2}}};
}

class Table {
 public:
  Table(std::string material_name, const fem::Material& material, bool coarsest)
      : material_(std::move(material_name)), sheet_(material), coarsest_(coarsest) {}

  void write() {
    std::printf(
        "material,integrator,precision,solver,newton_iterations,linear_tolerance,step_s,steps_not_converged,"
        "steps_repaired,solves,cpu_s,error_same_step_m,error_fine_m,energy_gain_j\n");
    fine_ = explicit_fall(fem::Precision::kDouble, 0.0, kFineCfl).states.back();
    for (const ExplicitScheme& scheme : explicit_schemes()) {
      for (const double cfl : scheme.cfls) {
        write_explicit(scheme, cfl);
        if (coarsest_) break;
      }
    }
    for (const ImplicitScheme& scheme : implicit_schemes()) {
      for (const double rate : scheme.rates) {
        write_implicit(scheme, rate);
        if (coarsest_) break;
      }
    }
  }

 private:
  static test::Fall checked(test::Fall fall) {
    KERF_CHECK(std::abs(fall.simulated - kEnd) < 1e-9, "every step covers its time");
    return fall;
  }

  [[nodiscard]] test::Fall explicit_fall(fem::Precision precision, double damping, double cfl) const {
    fem::IntegratorOptions options;
    options.kind = IntegratorKind::kExplicit;
    options.precision = precision;
    options.highest_mode_damping = damping;
    options.cfl = cfl;
    return checked(test::fall(sheet_, options, kExplicitRate, kEnd, 1));
  }

  [[nodiscard]] test::Fall implicit_fall(const ImplicitScheme& scheme, double rate, const Solving& solving) const {
    fem::IntegratorOptions options;
    options.kind = scheme.kind;
    options.linear_solver = solving.solver;
    options.newton_iterations = solving.newton_iterations;
    options.newton_tolerance = solving.newton_tolerance;
    options.linear_tolerance = solving.linear_tolerance;
    return checked(test::fall(sheet_, options, rate, kEnd, 1));
  }

  void write_explicit(const ExplicitScheme& scheme, double cfl) const {
    const test::Fall fall = explicit_fall(scheme.precision, scheme.damping, cfl);
    std::printf("%s,%s,%s,none,,,%.6g,,,,%.6f,,", material_.c_str(), scheme.name, scheme.precision_name,
                kEnd / fall.substeps, fall.seconds);
    write_end(fall);
  }

  void write_implicit(const ImplicitScheme& scheme, double rate) const {
    const test::Fall solved = implicit_fall(scheme, rate, kSolved);
    for (const Solving& solving : kSolvings) {
      const test::Fall fall = implicit_fall(scheme, rate, solving);
      write_implicit_start(scheme, rate, solving, fall);
      std::printf("%.5g,", test::largest_distance(fall.states.back(), solved.states.back()));
      write_end(fall);
    }
    write_implicit_start(scheme, rate, kSolved, solved);
    std::printf(",");
    write_end(solved);
  }

  void write_implicit_start(const ImplicitScheme& scheme, double rate, const Solving& solving,
                            const test::Fall& fall) const {
    std::printf("%s,%s,double,%s,%d,%.0e,%.6g,%d,%d,%d,%.6f,", material_.c_str(), scheme.name,
                name_of(solving.solver).option.data(), solving.newton_iterations, solving.linear_tolerance,
                1.0 / (rate * scheme.substeps), fall.not_converged, fall.repaired, fall.solves, fall.seconds);
  }

  void write_end(const test::Fall& fall) const {
    std::printf("%.5g,%.5g\n", test::largest_distance(fall.states.back(), fine_),
                sheet_.energy_gain(fall.states.back()));
    std::fflush(stdout);
  }

  std::string material_;
  test::FallingSheet sheet_;
  bool coarsest_;
  fem::State fine_;
};

}  // namespace
}  // namespace kerf::accuracy

int main(int argc, char** argv) {
  const bool is_wool = argc > 1 && std::strcmp(argv[1], "wool") == 0;
  const bool is_soft = argc > 1 && std::strcmp(argv[1], "soft") == 0;
  const bool coarsest = argc == 3 && std::strcmp(argv[2], "--coarsest") == 0;
  if ((!is_wool && !is_soft) || argc > 3 || (argc == 3 && !coarsest)) {
    std::fprintf(stderr, "time_errors soft|wool [--coarsest]\n");
    return 2;
  }
  const kerf::fem::Material material =
      is_wool ? kerf::fem::find_preset("wool").value() : kerf::fem::isotropic(1.0e6, 0.3, 5.0e-4, 1000.0);
  kerf::accuracy::Table(argv[1], material, coarsest).write();
  return 0;
}
