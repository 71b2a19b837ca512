// The cost of random cuts: substeps and time of a tick of 1/60 s after some random cubic curves of about 0.3 m in a
// sheet of 50 x 50 vertices that swings from one edge, with local inertia and without, and how far the two are
// apart.
//   random_cuts_bench [MATERIAL [SEED [CUTS...]]]   such as demo 1 0 1 5 10 20 50 100
// The error is that of a vertex after 0.05 s, against plain leapfrog in double on the same mesh; both have the damping
// that plain leapfrog can carry. "-": plain leapfrog would take more than kMostPlain substeps a tick.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "server/fem/explicit_integrator.h"
#include "tests/bench/cpu_time.h"
#include "tests/support/meshes.h"
#include "tests/support/random_cuts.h"

namespace kerf::bench {
namespace {

constexpr int kSide = 50;
constexpr double kTick = 1.0 / 60.0;
constexpr int kTicks = 24;
constexpr double kErrorTime = 0.05;  // s
constexpr double kMostPlain = 6000.0;

fem::IntegratorOptions options_of(bool has_local_inertia, fem::Precision precision) {
  fem::IntegratorOptions options;
  options.kind = fem::IntegratorKind::kExplicit;
  options.has_local_inertia = has_local_inertia;
  options.precision = precision;
  options.max_substeps = 100'000;
  return options;
}

struct Scene {
  mesh::TriangleMesh mesh = test::grid(kSide);
  fem::Model model;
  test::RandomCuts cuts;

  Scene(const fem::Material& material, std::uint64_t seed) : model(mesh, material), cuts(seed, mesh, model) {}

  [[nodiscard]] fem::State start() const {
    fem::State state;
    state.x.resize(mesh.num_vertices());
    state.v.resize(mesh.num_vertices());
    state.v.setZero();
    for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d p = mesh.rest_position(v);
      state.x.col(v) = Eigen::Vector3d(p.x(), p.y(), 1e-3 * std::sin(9.0 * p.x()) * std::cos(7.0 * p.y()));
    }
    return state;
  }
  [[nodiscard]] fem::Loads loads(const fem::State& start) const {
    fem::Loads loads;
    for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
      const bool is_held = mesh.rest_position(v).y() > 1.0 - 1e-9;
      if (is_held && mesh.has_material(v)) loads.pins.push_back({v, start.x.col(v)});
    }
    return loads;
  }
};

struct Run {
  fem::State state;
  double median_ms = 0.0;  // of a step
  int substeps = 0;
  std::uint32_t flags = 0;
};

Run run(const Scene& scene, const fem::Model& model, const fem::IntegratorOptions& options, double dt, int num_steps) {
  fem::ExplicitIntegrator integrator(options);
  integrator.rebuild(model);
  Run result{scene.start()};
  const fem::Loads loads = scene.loads(result.state);
  std::vector<double> ms;
  for (int i = 0; i < num_steps; ++i) {
    const double before = thread_cpu_s();
    const fem::StepStats stats = integrator.step(model, loads, dt, nullptr, result.state);
    ms.push_back(1e3 * (thread_cpu_s() - before));
    result.substeps = stats.substeps;
    result.flags |= stats.flags;
  }
  std::nth_element(ms.begin(), ms.begin() + num_steps / 2, ms.end());
  result.median_ms = ms[static_cast<std::size_t>(num_steps / 2)];
  return result;
}

// Errors of vertices, mm: "p99 / largest".
std::string error_of(const Scene& scene, fem::Material material) {
  fem::ExplicitIntegrator plain(options_of(false, fem::Precision::kDouble));
  plain.plan(scene.model, false);
  if (plain.planned_substeps(kTick) > kMostPlain) return "-";
  const double omega = std::sqrt(scene.model.stiffness_bound());
  material.stiffness_damping = 0.2 / omega;  // a damping ratio of 0.1 in the fastest mode
  const fem::Model model(scene.mesh, material);
  constexpr int kSteps = 3;
  const Run expected = run(scene, model, options_of(false, fem::Precision::kDouble), kErrorTime / kSteps, kSteps);
  const Run found = run(scene, model, options_of(true, fem::Precision::kMixed), kErrorTime / kSteps, kSteps);
  std::vector<double> errors;
  for (Eigen::Index v = 0; v < found.state.x.cols(); ++v) {
    errors.push_back(1e3 * (found.state.x.col(v) - expected.state.x.col(v)).norm());
  }
  std::sort(errors.begin(), errors.end());
  char text[64];
  std::snprintf(text, sizeof text, "%.2g / %.2g", errors[errors.size() * 99 / 100], errors.back());
  return text;
}

int main_of(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "demo";
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  std::vector<std::size_t> counts;
  for (int i = 3; i < argc; ++i) counts.push_back(std::strtoull(argv[i], nullptr, 10));
  if (counts.empty()) counts = {0, 1, 5, 10, 20, 50, 100};
  const Result<fem::Material> material = fem::find_preset(name);
  if (!material.ok()) {
    std::fprintf(stderr, "random_cuts_bench: %s\n", material.error().message.c_str());
    return 2;
  }
  Scene scene(*material, seed);
  const Run uncut = run(scene, scene.model, options_of(true, fem::Precision::kMixed), kTick, kTicks);
  const double uncut_per_vertex = uncut.median_ms / scene.mesh.num_vertices();
  std::printf("%s, seed %llu: uncut %d substeps, %.2f ms a tick\n", name.c_str(), static_cast<unsigned long long>(seed),
              uncut.substeps, uncut.median_ms);
  std::printf(
      "| cuts | vertices | plain substeps | ms | substeps | ms | a vertex, times uncut | clusters | vertices, "
      "largest | factors | follow ms | error mm, p99 / largest | flags |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  fem::ExplicitIntegrator following(options_of(true, fem::Precision::kMixed));
  following.rebuild(scene.model);
  for (const std::size_t count : counts) {
    std::size_t made = 0;
    double follow_s = 0.0;
    for (; scene.cuts.size() < count; ++made) {
      scene.cuts.make_one();
      const double before = thread_cpu_s();
      following.follow(scene.model);
      follow_s += thread_cpu_s() - before;
    }
    fem::ExplicitIntegrator plain(options_of(false, fem::Precision::kMixed));
    plain.rebuild(scene.model);
    const double plain_substeps = plain.planned_substeps(kTick);
    std::string plain_ms = "-";
    if (plain_substeps <= kMostPlain) {
      char text[32];
      const Run of_plain = run(scene, scene.model, options_of(false, fem::Precision::kMixed), kTick, 4);
      std::snprintf(text, sizeof text, "%.1f", of_plain.median_ms);
      plain_ms = text;
    }
    const Run tested = run(scene, scene.model, options_of(true, fem::Precision::kMixed), kTick, kTicks);
    const fem::LocalInertia& inertia = following.inertia();
    const double per_vertex = tested.median_ms / scene.mesh.num_vertices();
    std::printf("| %zu | %d | %.0f | %s | %d | %.2f | %.1f | %zu | %zu, %zu | %zu | %.2f | %s | %x |\n", count,
                scene.mesh.num_vertices(), plain_substeps, plain_ms.c_str(), tested.substeps, tested.median_ms,
                per_vertex / uncut_per_vertex, inertia.clusters().size(), inertia.num_vertices(), inertia.largest(),
                inertia.num_entries(), made > 0 ? 1e3 * follow_s / static_cast<double>(made) : 0.0,
                error_of(scene, *material).c_str(), tested.flags);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  return kerf::bench::main_of(argc, argv);
}
