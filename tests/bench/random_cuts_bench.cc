// The cost of random cuts: substeps and time of a tick after some random cubic curves of about 0.3 m, beside the
// sheet uncut, and how far it is from plain leapfrog on the same mesh.
//   random_cuts_bench [MATERIAL [SEED [CUTS...]]]   e.g. demo 1 0 1 5 10 20 50 100 200
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "server/base/random.h"
#include "server/cut/cut.h"
#include "server/fem/explicit_integrator.h"
#include "server/mesh/grid_mesh.h"
#include "tests/bench/cpu_time.h"
#include "tests/support/meshes.h"

namespace kerf::bench {
namespace {

constexpr int kSide = 50;
constexpr double kTick = 1.0 / 60.0;

cut::Curve random_cubic(SeededRandom& random) {
  const Eigen::Vector2d middle(random.uniform(0.1, 0.9), random.uniform(0.1, 0.9));
  const double angle = random.uniform(0.0, 6.283185307179586);
  const Eigen::Vector2d along = 0.15 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const auto jitter = [&] { return Eigen::Vector2d(random.uniform(-0.08, 0.08), random.uniform(-0.08, 0.08)); };
  return cut::CubicBezier{
      {middle - along, middle - along / 3.0 + jitter(), middle + along / 3.0 + jitter(), middle + along}};
}

struct Run {
  fem::State state;
  std::vector<double> tick_ms;
  fem::StepStats stats;
  std::uint32_t flags = 0;
};

fem::IntegratorOptions options_of(bool has_local_inertia, fem::Precision precision) {
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kExplicit;
  options.has_local_inertia = has_local_inertia;
  options.precision = precision;
  options.max_substeps = 1'000'000;
  return options;
}

Run fall(const fem::Model& model, const mesh::TriangleMesh& mesh, const fem::IntegratorOptions& options,
         double duration, int num_steps, std::string* explanation = nullptr) {
  fem::ExplicitIntegrator integrator(options);
  integrator.rebuild(model);
  if (explanation != nullptr) *explanation = integrator.explanation();
  Run run;
  run.state.x.resize(mesh.num_vertices());
  run.state.v.resize(mesh.num_vertices());
  run.state.v.setZero();
  fem::Loads loads;
  loads.gravity = {0.0, 0.0, -9.81};
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector2d p = mesh.rest_position(v);
    run.state.x.col(v) = Eigen::Vector3d(p.x(), p.y(), 0.001 * std::sin(9.0 * p.x()) * std::cos(7.0 * p.y()));
    const bool is_corner = (p - Eigen::Vector2d(0, 1)).norm() < 1e-9 || (p - Eigen::Vector2d(1, 1)).norm() < 1e-9;
    if (is_corner && mesh.has_material(v)) loads.pins.push_back({v, run.state.x.col(v)});
  }
  for (int i = 0; i < num_steps; ++i) {
    const double before = thread_cpu_s();
    run.stats = integrator.step(model, loads, duration / num_steps, nullptr, run.state);
    run.tick_ms.push_back(1e3 * (thread_cpu_s() - before));
    run.flags |= run.stats.flags;
  }
  return run;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

int run(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "demo";
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  std::vector<int> counts;
  for (int i = 3; i < argc; ++i) counts.push_back(std::atoi(argv[i]));
  if (counts.empty()) counts = {0, 1, 5, 10, 20, 50, 100};
  const bool with_error = std::getenv("ERROR") != nullptr;
  const bool with_plain = std::getenv("PLAIN") != nullptr;
  Result<fem::Material> material = fem::find_preset(name);
  if (const char* beta = std::getenv("BETA"); beta != nullptr && material.ok())
    material->stiffness_damping = std::atof(beta);
  if (!material.ok()) return 2;
  SeededRandom random(seed);
  mesh::TriangleMesh mesh = test::grid(kSide);
  fem::Model model(mesh, *material);
  double uncut = 0.0;
  int made = 0;
  for (const int count : counts) {
    while (made < count) {
      const Result<cut::CutPlan> planned = cut::plan(mesh, {random_cubic(random), {}, {}});
      if (!planned.ok()) continue;
      const Result<cut::CutOutcome> done = cut::apply(mesh, *planned);
      if (!done.ok() || done->status != cut::CutStatus::kApplied) continue;
      model.apply(mesh, done->edit);
      ++made;
    }
    for (const fem::Precision precision : {fem::Precision::kDouble, fem::Precision::kMixed}) {
      if (std::getenv("MIXED") != nullptr && precision == fem::Precision::kDouble) continue;
      std::string explanation;
      const Run tested = fall(model, mesh, options_of(true, precision),
                              (std::getenv("TICKS") ? std::atoi(std::getenv("TICKS")) : 12) * kTick,
                              (std::getenv("TICKS") ? std::atoi(std::getenv("TICKS")) : 12), &explanation);
      const double ms = median(tested.tick_ms);
      const double per_vertex = ms / mesh.num_vertices();
      if (count == 0) uncut = per_vertex;
      std::printf(
          "%s %d cuts, %s: V %d, %d substeps, %.2f ms a tick, %.2f x uncut a vertex, flags %x, strain %.2f; %s\n",
          name.c_str(), count, precision == fem::Precision::kDouble ? "double" : "mixed", mesh.num_vertices(),
          tested.stats.substeps, ms, uncut > 0.0 ? per_vertex / uncut : 0.0, tested.flags, tested.stats.max_strain,
          explanation.c_str());
      if (with_plain) {
        const Run plain = fall(model, mesh, options_of(false, precision), 2 * kTick, 2);
        std::printf("  plain: %d substeps, %.2f ms a tick\n", plain.stats.substeps, median(plain.tick_ms));
      }
      if (with_error) {
        fem::IntegratorOptions reference = options_of(false, fem::Precision::kDouble);
        const Run plain = fall(model, mesh, reference, 0.05, 3);
        const Run mine = fall(model, mesh, options_of(true, precision), 0.05, 3);
        std::vector<double> errors;
        for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
          if (mesh.has_material(v)) errors.push_back(1e3 * (plain.state.x.col(v) - mine.state.x.col(v)).norm());
        }
        std::sort(errors.begin(), errors.end());
        std::printf("  error at 0.05 s, mm: max %.4f, p99 %.4f, median %.2g; plain %d substeps\n", errors.back(),
                    errors[errors.size() * 99 / 100], errors[errors.size() / 2], plain.stats.substeps);
      }
    }
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  return kerf::bench::run(argc, argv);
}
