#include "tests/evaluation/cut_cost.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <variant>
#include <vector>

#include "server/base/check.h"
#include "server/base/random.h"
#include "server/core/fem/step/integrator.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/race_scene.h"
#include "tests/support/random_cuts.h"

namespace kerf::evaluation {
namespace {

constexpr std::uint64_t kCutSeed = 14159265;  // the first decimals of pi
constexpr int kCurves = 10;
constexpr int kPointsOnCurve = 257;
constexpr int kCutRepeats = 5;  // of a timed cut; the least time counts

cut::CutRequest request_of(const cut::Curve& curve, cut::Method method) {
  cut::CutOptions options;
  options.method = method;
  return {curve, options, {}};
}

// The sheet's own border; all other edges with a triangle on one side alone are lips.
bool is_border(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {mesh.bounding_box().min()[axis], mesh.bounding_box().max()[axis]}) {
      if (std::max(std::abs(a[axis] - side), std::abs(b[axis] - side)) < 1e-9) return true;
    }
  }
  return false;
}

nlohmann::json lips_of(const mesh::TriangleMesh& mesh) {
  nlohmann::json lips = nlohmann::json::array();
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      if (mesh.neighbour(t, static_cast<int>(k)) != mesh::kNone) continue;
      const Eigen::Vector2d a = mesh.rest_position(mesh.vertices(t)[(k + 1) % 3]);
      const Eigen::Vector2d b = mesh.rest_position(mesh.vertices(t)[(k + 2) % 3]);
      if (!is_border(mesh, a, b)) lips.push_back({a.x(), a.y(), b.x(), b.y()});
    }
  }
  return lips;
}

}  // namespace

CutSheet cut_sheet(int side, int cuts, cut::Method method) {
  CutSheet sheet{bench::grid(side), {}};
  SeededRandom random(kCutSeed);
  while (static_cast<int>(sheet.curves.size()) < cuts) {
    const cut::Curve curve = test::random_cubic(random);
    const Result<cut::CutPlan> plan = cut::plan(sheet.mesh, request_of(curve, method));
    if (!plan.ok()) continue;
    const Result<cut::CutOutcome> outcome = cut::apply(sheet.mesh, *plan);
    if (outcome.ok() && outcome->status == cut::CutStatus::kApplied) sheet.curves.push_back(curve);
  }
  return sheet;
}

nlohmann::json points_along(const cut::Curve& curve) {
  const std::vector<Eigen::Vector2d>& control = std::get<cut::CubicBezier>(curve).points;
  nlohmann::json points = nlohmann::json::array();
  for (int i = 0; i < kPointsOnCurve; ++i) {
    const double s = i / (kPointsOnCurve - 1.0), r = 1.0 - s;
    const Eigen::Vector2d at =
        r * r * r * control[0] + 3.0 * r * r * s * control[1] + 3.0 * r * s * s * control[2] + s * s * s * control[3];
    points.push_back({at.x(), at.y()});
  }
  return points;
}

nlohmann::json measure_cuts(int side, cut::Method method, bool has_times) {
  nlohmann::json rows = nlohmann::json::array();
  const mesh::TriangleMesh uncut = bench::grid(side);
  for (const cut::Curve& curve : cut_sheet(side, kCurves, cut::Method::kNeighbourhood).curves) {
    double least = std::numeric_limits<double>::infinity();
    nlohmann::json row{{"curve", points_along(curve)}};
    for (int repeat = 0; repeat < (has_times ? kCutRepeats : 1); ++repeat) {
      bench::Scene scene(uncut, 0.0, false);
      const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator({});
      integrator->rebuild(scene.model);
      const double begin = bench::thread_cpu_s();
      const Result<cut::CutPlan> plan = cut::plan(scene.mesh, request_of(curve, method));
      KERF_CHECK(plan.ok(), "a cut of the evaluation is refused");
      const Result<cut::CutOutcome> outcome = cut::apply(scene.mesh, *plan);
      KERF_CHECK(outcome.ok(), "a cut of the evaluation is refused");
      scene.model.apply(scene.mesh, outcome->edit);
      integrator->follow(scene.model);
      integrator->prepare();
      least = std::min(least, bench::thread_cpu_s() - begin);
      row["lips"] = lips_of(scene.mesh);
      row["new_vertices"] = scene.mesh.num_vertices() - uncut.num_vertices();
    }
    if (has_times) row["ms"] = 1e3 * least;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace kerf::evaluation
