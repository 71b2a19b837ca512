#include "tests/bench/race_programs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "tests/bench/cpu_time.h"
#include "tests/bench/race_bullet.h"
#include "tests/bench/race_scene.h"

namespace kerf::bench {
namespace {

constexpr double kRestStretch = 0.00172;  // -, of the centre column: rho g L / (E t) (1 - nu^2), less half a cell

Entry own(const std::string& setting, const fem::IntegratorOptions& options) {
  return {"Kerf", setting, [options](const Scene& scene) { return make_own(scene, options); }};
}

Entry implicit_euler(const std::string& setting, int newton_iterations, linear::LinearSolverKind solver) {
  return own(setting, implicit_options(fem::IntegratorKind::kImplicitEuler, newton_iterations, solver));
}

std::vector<Entry> own_entries() {
  return {own("explicit, mixed", explicit_options(fem::Precision::kMixed)),
          own("explicit, double", explicit_options(fem::Precision::kDouble)),
          implicit_euler("implicit Euler, 5 Newton, factor", 5, linear::LinearSolverKind::kFactorCg),
          implicit_euler("the source's: implicit Euler, 1 solve, plain CG", 1, linear::LinearSolverKind::kPlainCg),
          implicit_euler("the same, block-Jacobi CG", 1, linear::LinearSolverKind::kBlockJacobiCg),
          implicit_euler("the same, direct", 1, linear::LinearSolverKind::kDirect)};
}

long ticks_of(double duration) {
  return std::lround(duration / kTick);
}

Eigen::Matrix3Xd positions_at(const Entry& entry, const Scene& scene, double time) {
  const std::unique_ptr<Contender> contender = entry.enter(scene);
  for (long i = 0; i < ticks_of(time); ++i) contender->tick();
  return contender->positions();
}

// -, of the edge of the mesh that is longest against its length at rest.
double largest_stretch(const mesh::TriangleMesh& mesh, const Eigen::Matrix3Xd& x) {
  double largest = 0.0;
  for (int t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = mesh.vertices(t)[k];
      const int b = mesh.vertices(t)[(k + 1) % 3];
      const double at_rest = (mesh.rest_position(b) - mesh.rest_position(a)).norm();
      largest = std::max(largest, (x.col(b) - x.col(a)).norm() / at_rest - 1.0);
    }
  }
  return largest;
}

struct Swing {
  std::vector<double> ms;  // CPU, of each tick, ascending
  double max_stretch = 0.0;
};

Swing swing(const Entry& entry, int side) {
  const Scene scene(grid(side), 2.0, false);
  const std::unique_ptr<Contender> contender = entry.enter(scene);
  Swing result;
  for (long i = 0; i < ticks_of(2.0); ++i) {
    const double begin = thread_cpu_s();
    contender->tick();
    result.ms.push_back(1e3 * (thread_cpu_s() - begin));
    result.max_stretch = std::max(result.max_stretch, largest_stretch(scene.mesh, contender->positions()));
  }
  std::sort(result.ms.begin(), result.ms.end());
  return result;
}

// -, largest of the edges along the middle of a grid.
double column_stretch(int side, const Eigen::Matrix3Xd& x) {
  double largest = 0.0;
  for (int j = 0; j + 1 < side; ++j) {
    const int v = j * side + side / 2;
    largest = std::max(largest, (x.col(v + side) - x.col(v)).norm() * (side - 1) - 1.0);
  }
  return largest;
}

// The same of a grid that hangs and came to rest: after 3 s or more, and no more than a thousandth of it in the last.
double rest_stretch(const Entry& entry, int side) {
  const Scene scene(grid(side), 8.0, true);
  const std::unique_ptr<Contender> contender = entry.enter(scene);
  double before = -1.0;
  double stretch = 0.0;
  for (int second = 0; second < 30 && (second < 3 || std::abs(stretch - before) > 1e-3 * stretch); ++second) {
    for (long i = 0; i < ticks_of(1.0); ++i) contender->tick();
    before = std::exchange(stretch, column_stretch(side, contender->positions()));
  }
  return stretch;
}

}  // namespace

bool compare_programs(const std::string& mesh, int side, std::string_view only) {
  std::vector<Entry> entries = own_entries();
  const std::vector<Entry> bullet = bullet_entries();
  entries.insert(entries.end(), bullet.begin(), bullet.end());
  const Scene undamped(grid(side), 0.0, false);
  const Eigen::Matrix3Xd reference = positions_at(own("reference", reference_options()), undamped, 0.3);
  std::printf(
      "| %s: program | setting | median ms | worst ms | error mm | largest stretch, swing | at rest, centre column |\n"
      "|---|---|---|---|---|---|---|\n",
      mesh.c_str());
  bool is_good = true;
  for (const Entry& entry : entries) {
    if ((entry.program + " " + entry.setting).find(only) == std::string::npos) continue;
    const double error = (positions_at(entry, undamped, 0.3) - reference).colwise().norm().maxCoeff();
    const Swing swung = swing(entry, side);
    const double rest = rest_stretch(entry, side);
    std::printf("| %s | %s | %.2f | %.2f | %.3f | %.2f %% | %.4f %% |\n", entry.program.c_str(), entry.setting.c_str(),
                swung.ms[swung.ms.size() / 2], swung.ms.back(), 1e3 * error, 100.0 * swung.max_stretch, 100.0 * rest);
    std::fflush(stdout);
    const bool has_contract = entry.program == "Kerf" && entry.setting.starts_with("explicit");
    is_good = is_good && (!has_contract || std::abs(rest - kRestStretch) < 0.01 * kRestStretch);
  }
  if (bullet.empty())
    std::printf("built without Bullet, whose rows are missing: install libbullet-dev and configure\n");
  return is_good;
}

}  // namespace kerf::bench
