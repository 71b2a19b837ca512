// The table of tests/bench/README.md "The race": the scene at which other programs are compared, per tick of 1/60 s.
//   race_bench [MESH]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/check.h"
#include "server/cut/cut.h"
#include "server/fem/integrator.h"
#include "server/mesh/grid_mesh.h"
#include "tests/support/cut_patterns.h"

namespace kerf::bench {
namespace {

constexpr double kTick = 1.0 / 60.0;      // s
constexpr double kWorstError = 1e-4;      // m, of a vertex
constexpr double kRestStretch = 0.00172;  // -, of the centre column: rho g L / (E t) (1 - nu^2), less half a cell

constexpr std::pair<const char*, fem::Precision> kPrecisions[] = {{"double", fem::Precision::kDouble},
                                                                  {"mixed", fem::Precision::kMixed}};

struct Entry {
  std::string name;
  double compared_at;  // s, with the reference
  mesh::TriangleMesh mesh;
};

mesh::TriangleMesh grid(int side) {
  return mesh::make_grid({.num_x = side, .num_y = side}).value();
}

mesh::TriangleMesh cut_grid(int side) {
  mesh::TriangleMesh mesh = grid(side);
  for (const cut::Curve& curve : test::kirigami(5, 4)) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {curve, {}, {}});
    KERF_CHECK(plan.ok() && cut::apply(mesh, *plan).ok(), "the benchmark's cut is refused");
  }
  return mesh;
}

fem::Material cloth(double mass_damping) {
  fem::Material material = fem::isotropic(2.0e6, 0.3, 5.0e-4, 400.0);
  material.mass_damping = mass_damping;
  return material;
}

// Pinned along the upper edge; flat, horizontal or hanging.
struct Scene {
  Scene(const mesh::TriangleMesh& mesh, double mass_damping, bool hangs) : model(mesh, cloth(mass_damping)) {
    state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
    state.v = state.x;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d at = mesh.rest_position(v);
      state.x.col(v) = hangs ? Eigen::Vector3d(at.x(), 0.0, at.y()) : Eigen::Vector3d(at.x(), at.y(), 0.0);
      if (at.y() > 1.0 - 1e-9) loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
    }
  }
  fem::Model model;
  fem::State state;
  fem::Loads loads;
};

struct Run {
  std::vector<double> ms;  // CPU, of each tick
  int substeps = 0;        // of the last tick
  double max_strain = 0.0;
  std::uint32_t flags = 0;
};

Run run(Scene& scene, const fem::IntegratorOptions& options, double duration) {
  const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
  integrator->rebuild(scene.model);
  Run result;
  for (long i = 0; i < std::lround(duration / kTick); ++i) {
    timespec begin{}, end{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
    const fem::StepStats stats = integrator->step(scene.model, scene.loads, kTick, nullptr, scene.state);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    result.ms.push_back(1e3 * static_cast<double>(end.tv_sec - begin.tv_sec) +
                        1e-6 * static_cast<double>(end.tv_nsec - begin.tv_nsec));
    result.substeps = stats.substeps;
    result.max_strain = std::max(result.max_strain, stats.max_strain);
    result.flags |= stats.flags;
  }
  return result;
}

fem::IntegratorOptions explicit_options(fem::Precision precision) {
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kExplicit;
  options.precision = precision;
  return options;
}

// The same mesh in double with a tenth of the stable step, no damping, and bending in each substep.
fem::IntegratorOptions reference_options() {
  fem::IntegratorOptions options = explicit_options(fem::Precision::kDouble);
  options.cfl = 0.1;
  options.highest_mode_damping = 0.0;
  options.max_substeps = 1'000'000;
  return options;
}

fem::State state_of(const Entry& entry, const fem::IntegratorOptions& options) {
  Scene scene(entry.mesh, 0.0, false);
  run(scene, options, entry.compared_at);
  return scene.state;
}

// -, largest of the edges along the middle of a grid that came to rest.
double rest_stretch(int side, const fem::IntegratorOptions& options) {
  Scene scene(grid(side), 8.0, true);
  run(scene, options, 3.0);
  double largest = 0.0;
  for (int j = 0; j + 1 < side; ++j) {
    const int v = j * side + side / 2;
    const double length = (scene.state.x.col(v + side) - scene.state.x.col(v)).norm();
    largest = std::max(largest, length * (side - 1) - 1.0);
  }
  return largest;
}

bool measure(const Entry& entry) {
  const fem::State reference = state_of(entry, reference_options());
  bool all_good = true;
  for (const auto& [label, precision] : kPrecisions) {
    const fem::IntegratorOptions options = explicit_options(precision);
    const fem::State tested = state_of(entry, options);
    const double error = (tested.x - reference.x).colwise().norm().maxCoeff();
    Scene swing(entry.mesh, 2.0, false);
    Run result = run(swing, options, 2.0);
    std::sort(result.ms.begin(), result.ms.end());
    const double median = result.ms[result.ms.size() / 2];
    const bool is_good = error <= kWorstError && result.flags == 0;
    std::printf("| %s | %s | %d | %.2f | %.2f | %.1f | %.4f | %.2f %% |%s\n", entry.name.c_str(), label,
                result.substeps, median, result.ms.back(), 1e3 * median / (result.substeps + 2), 1e3 * error,
                100.0 * result.max_strain, is_good ? "" : " FAILED");
    std::fflush(stdout);
    all_good = all_good && is_good;
  }
  return all_good;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  using namespace kerf::bench;
  const std::string_view only = argc > 1 ? argv[1] : "";
  const std::vector<Entry> entries{
      {"50x50", 0.3, grid(50)},
      {"81x81", 0.3, grid(81)},
      {"160x160", 0.3, grid(160)},
      {"50x50 Delaunay", 0.3, kerf::mesh::make_jittered_grid({.num_x = 50, .num_y = 50}, 1).value()},
      // Later its flaps buckle, which way depends on damping: 1.2 mm at 0.3 s from that alone.
      {"50x50, 20 cuts", 0.1, cut_grid(50)},
  };
  std::printf(
      "| mesh | precision | substeps | median ms | worst ms | us a substep | error mm | largest strain |\n"
      "|---|---|---|---|---|---|---|---|\n");
  bool is_good = true;
  for (const Entry& entry : entries) {
    if (entry.name.find(only) != std::string::npos) is_good = measure(entry) && is_good;
  }
  if (only.empty()) {
    const double stretch = rest_stretch(50, explicit_options(kerf::fem::Precision::kMixed));
    std::printf("hanging at rest: centre column %.4f %%\n", 100.0 * stretch);
    is_good = is_good && std::abs(stretch - kRestStretch) < 0.01 * kRestStretch;
  }
  return is_good ? 0 : 1;
}
