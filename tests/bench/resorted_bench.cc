#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "server/base/check.h"
#include "server/base/random.h"
#include "server/base/state_hash.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/leapfrog/membrane_layout.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/bench/cpu_time.h"
#include "tests/bench/expected.h"
#include "tests/bench/resorted_mesh.h"
#include "tests/support/cut_patterns.h"

// Measures the largest possible gain of sorting a cut sheet again. It compares the race's sheet as cuts leave it with
// the same sheet, its triangles, or triangles and vertices, numbered by place.
namespace kerf::bench {
namespace {

constexpr int kSubsteps = 120;  // of a round, about
constexpr int kResortedRounds = 7;
// Short steps before, which finish work deferred by cuts: LeapfrogSweep rebuilds 16 slices of bending in each.
constexpr int kStepsBefore = 130;

struct Row {
  const char* name;
  Order order;
};
// Beside the sheet as it is, with all that followed its cuts.
constexpr Row kRows[] = {{"rebuilt", Order::kSame},
                         {"triangles", Order::kTriangles},
                         {"new_vertices", Order::kNewVertices},
                         {"rows", Order::kRows},
                         {"curve", Order::kCurve}};

struct ResortedSetting {
  std::string name;
  int side;  // vertices
  std::vector<cut::Curve> cuts;
  fem::Precision precision;
};

// Straight ones that keep apart: where cuts cross at random, slivers leave steps that floats cannot hold.
std::vector<cut::Curve> random_slits() {
  constexpr std::size_t kSlits = 200;
  constexpr int kSamples = 5;
  constexpr double kHalfLength = 0.02;  // m
  constexpr double kApart = 0.025;      // m
  SeededRandom random(23);
  std::vector<cut::Curve> slits;
  std::vector<Eigen::Vector2d> taken;
  while (slits.size() < kSlits) {
    const Eigen::Vector2d middle(random.uniform(0.05, 0.95), random.uniform(0.05, 0.95));
    const Eigen::Vector2d half = test::polar(Eigen::Vector2d::Zero(), kHalfLength, random.uniform(0.0, 3.14159));
    std::vector<Eigen::Vector2d> samples;
    for (int i = 0; i < kSamples; ++i) samples.emplace_back(middle + (2.0 * i / (kSamples - 1) - 1.0) * half);
    const auto is_near = [&](const Eigen::Vector2d& at) {
      return std::any_of(taken.begin(), taken.end(), [&](const auto& other) { return (at - other).norm() < kApart; });
    };
    if (std::any_of(samples.begin(), samples.end(), is_near)) continue;
    taken.insert(taken.end(), samples.begin(), samples.end());
    slits.emplace_back(cut::Polyline{{middle - half, middle + half}});
  }
  return slits;
}

// A sheet that is held by its upper edge.
struct Hung {
  mesh::TriangleMesh mesh;
  fem::Model model;
  std::unique_ptr<fem::Integrator> integrator;
  fem::Loads loads;
  fem::State start;  // of each round
  fem::State state;
  double duration = 0.0;  // s, of a round

  Hung(mesh::TriangleMesh sheet, fem::Precision precision)
      : mesh(std::move(sheet)), model(mesh, fem::isotropic(2.0e6, 0.3, 5.0e-4, 400.0)) {
    fem::IntegratorOptions options;
    options.kind = fem::IntegratorKind::kExplicit;
    options.precision = precision;
    integrator = fem::make_integrator(options);
    integrator->rebuild(model);
  }
  // After the last cut.
  void make_ready() {
    integrator->prepare();
    duration = kSubsteps * 1.8 / std::sqrt(model.stiffness_bound().value());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d at = mesh.rest_position(v);
      if (at.y() > 1.0 - 1e-9) loads.pins.push_back({v, {at.x(), at.y(), 0.0}, Eigen::Vector3d::Zero()});
    }
  }
  fem::StepStats round(double dt) {
    state = start;
    return integrator->step(model, loads, dt, nullptr, state);
  }
};

// As a product makes it: a grid that was cut, and everything following each cut.
Hung cut_sheet(const ResortedSetting& setting) {
  Hung sheet(mesh::make_grid({.num_x = setting.side, .num_y = setting.side}).value(), setting.precision);
  int made = 0;
  for (const cut::Curve& curve : setting.cuts) {
    const Result<cut::CutPlan> plan = cut::plan(sheet.mesh, {curve, {}, {}});
    if (!plan.ok()) continue;
    const Result<cut::CutOutcome> outcome = cut::apply(sheet.mesh, *plan);
    if (!outcome.ok() || outcome->status != cut::CutStatus::kApplied) continue;
    sheet.model.apply(sheet.mesh, outcome->edit);
    sheet.integrator->follow(sheet.model);
    ++made;
  }
  KERF_CHECK(made > static_cast<int>(setting.cuts.size()) * 9 / 10, "the benchmark's cuts are refused");
  sheet.make_ready();
  sheet.start.x.resize(sheet.mesh.num_vertices());
  sheet.start.v = Eigen::Matrix3Xd::Zero(3, sheet.mesh.num_vertices());
  for (int v = 0; v < sheet.mesh.num_vertices(); ++v) {
    const Eigen::Vector2d at = sheet.mesh.rest_position(v);
    sheet.start.x.col(v) = Eigen::Vector3d(at.x(), at.y(), 0.02 * std::sin(5.0 * at.x()) * (1.0 - at.y()));
    sheet.start.v.col(v).z() = std::cos(4.0 * at.x()) * (1.0 - at.y());
  }
  for (int i = 0; i < kStepsBefore; ++i) sheet.round(sheet.duration / kSubsteps);
  return sheet;
}

Hung resorted(const Hung& from, const Numbering& numbering, fem::Precision precision) {
  Hung sheet(renumbered(from.mesh, numbering), precision);
  sheet.make_ready();
  sheet.duration = from.duration;
  sheet.start = from.start;
  for (Eigen::Index v = 0; v < from.start.x.cols(); ++v) {
    const mesh::VertexId to = numbering.vertices[static_cast<std::size_t>(v)];
    sheet.start.x.col(to) = from.start.x.col(v);
    sheet.start.v.col(to) = from.start.v.col(v);
  }
  return sheet;
}

// m, largest of a vertex.
double distance(const Hung& a, const Hung& b, const Numbering& b_from_a) {
  double largest = 0.0;
  for (Eigen::Index v = 0; v < a.state.x.cols(); ++v) {
    const mesh::VertexId to = b_from_a.vertices[static_cast<std::size_t>(v)];
    largest = std::max(largest, (a.state.x.col(v) - b.state.x.col(to)).norm());
  }
  return largest;
}

// Triangles that do not form the grid's pattern of quads.
double num_irregular(const Hung& sheet) {
  fem::MembraneLayout layout;
  layout.rebuild(sheet.model);
  const auto lanes = layout.lanes();
  return static_cast<double>(std::count_if(lanes.begin(), lanes.end(), [](auto slot) { return slot != mesh::kNone; }));
}

std::uint64_t hash_of(const std::vector<Hung>& sheets) {
  StateHash hash;
  for (const Hung& sheet : sheets) {
    hash.add_span(std::span<const double>(sheet.state.x.data(), static_cast<std::size_t>(sheet.state.x.size())));
  }
  return hash.value();
}

void resort(benchmark::State& state, const ResortedSetting& setting) {
  std::vector<Hung> sheets;
  sheets.push_back(cut_sheet(setting));
  std::vector<Numbering> numberings{number(sheets[0].mesh, setting.side, Order::kSame)};
  for (const Row& row : kRows) {
    numberings.push_back(number(sheets[0].mesh, setting.side, row.order));
    sheets.push_back(resorted(sheets[0], numberings.back(), setting.precision));
  }
  std::vector<double> least(sheets.size(), std::numeric_limits<double>::max());  // s, of a substep
  std::vector<int> substeps(sheets.size(), 0);
  for (auto _ : state) {
    double all = 0.0;
    for (std::size_t i = 0; i < sheets.size(); ++i) {
      const double begin = thread_cpu_s();
      const fem::StepStats stats = sheets[i].round(sheets[i].duration);
      const double spent = thread_cpu_s() - begin;
      if (stats.flags != 0) state.SkipWithError("a step reports a flag");
      substeps[i] = stats.substeps;
      all += spent;
      least[i] = std::min(least[i], spent / substeps[i]);
    }
    state.SetIterationTime(all);
  }
  // Sums in another order: rounding of one step.
  const double rounding = setting.precision == fem::Precision::kDouble ? 1e-11 : 1e-6;  // m
  state.counters["vertices"] = sheets[0].mesh.num_vertices();
  state.counters["triangles"] = sheets[0].mesh.num_solid_triangles();
  state.counters["substeps"] = substeps[0];
  state.counters["as_cut_us"] = 1e6 * least[0];
  state.counters["as_cut_irregular"] = num_irregular(sheets[0]);
  double farthest = 0.0;
  for (std::size_t i = 1; i < sheets.size(); ++i) {
    const std::string name = kRows[i - 1].name;
    state.counters[name + "_us"] = 1e6 * least[i];
    state.counters[name + "_irregular"] = num_irregular(sheets[i]);
    farthest = std::max(farthest, distance(sheets[0], sheets[i], numberings[i]));
    if (substeps[i] != substeps[0]) state.SkipWithError("sorted anew, a sheet takes other substeps");
  }
  state.counters["farthest_nm"] = 1e9 * farthest;
  if (distance(sheets[0], sheets[1], numberings[1]) > 0.0) state.SkipWithError("rebuilt, a sheet moves otherwise");
  if (!(farthest < rounding)) state.SkipWithError("sorted anew, a sheet moves otherwise than by rounding");
  expect_hash(state, setting.name, hash_of(sheets));
}

const bool kResortedRegistered = [] {
  const auto add = [](const std::string& cuts, std::vector<cut::Curve> curves, int side) {
    for (const auto& [label, precision] :
         {std::pair("double", fem::Precision::kDouble), {"mixed", fem::Precision::kMixed}}) {
      const std::string name = "resorted/" + cuts + "/" + label + "/" + std::to_string(side * side);
      const ResortedSetting setting{name, side, curves, precision};
      benchmark::RegisterBenchmark(name.c_str(), [setting](benchmark::State& state) { resort(state, setting); })
          ->Iterations(kResortedRounds)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  };
  for (const int side : {50, 160}) {
    add("slits", test::kirigami(5, 4), side);
    add("random", random_slits(), side);
  }
  return true;
}();

}  // namespace
}  // namespace kerf::bench
