// Checks what clusters with local inertia keep, on sheets cut so that some of their triangles are tiny.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "server/base/state_hash.h"
#include "server/core/fem/step/explicit_integrator.h"
#include "tests/fem/cut_sheet.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/trials.h"

namespace kerf::fem {
namespace {

Loads no_forces() {
  Loads loads;
  loads.gravity.setZero();
  return loads;
}

std::uint64_t hash_of(const State& state) {
  StateHash hash;
  hash.add_span(std::span<const double>(state.x.data(), static_cast<std::size_t>(state.x.size())));
  hash.add_span(std::span<const double>(state.v.data(), static_cast<std::size_t>(state.v.size())));
  return hash.value();
}

// Some steps of a new integrator.
State stepped(const Model& model, ExplicitIntegrator& integrator, State state, const Loads& loads, int num_steps,
              double dt = kTick) {
  for (int i = 0; i < num_steps; ++i) {
    const StepStats stats = integrator.step(model, loads, dt, nullptr, state);
    EXPECT_EQ(stats.flags, 0U) << i;
  }
  return state;
}

// J, with the inertia that it is moved by.
double energy_of(const Model& model, const ExplicitIntegrator& integrator, const State& state, const Loads& loads) {
  return model.energies(state, loads.gravity).total() + integrator.inertia().added_energy(state.v);
}

class LocalInertiaOf : public testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(EachPrecision, LocalInertiaOf, testing::Values(Precision::kDouble, Precision::kMixed),
                         [](const auto& tested) { return tested.param == Precision::kDouble ? "Double" : "Mixed"; });

// Covers clusters with a dense inverse, and larger ones.
TEST(LocalInertia, ClustersSolveForTheirInertia) {
  const CutSheet sheet(50);
  ExplicitIntegrator integrator(explicit_options(Precision::kDouble));
  integrator.rebuild(sheet.model);
  ASSERT_FALSE(integrator.inertia().empty());
  const auto num_vertices = static_cast<std::size_t>(sheet.mesh.num_vertices());
  for (const InertiaCluster* const cluster : integrator.inertia().clusters()) {
    const std::span<const mesh::VertexId> vertices = cluster->vertices();
    std::vector<linear::Lanes16<double>> of_double(vertices.size() / 4 + 1);
    std::vector<linear::Lanes16<float>> of_float(of_double.size());
    double* const values = of_double.front().lane.data();
    float* const rounded = of_float.front().lane.data();
    for (std::size_t i = 0; i < 4 * vertices.size(); ++i) {
      values[i] = 0.25 * static_cast<double>(i % 7) - 0.5;
      rounded[i] = static_cast<float>(values[i]);
    }
    cluster->solve(values);
    cluster->solve(rounded);
    std::vector<double> product(num_vertices, 0.0), velocity(num_vertices, 0.0);
    double largest = 0.0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto v = static_cast<std::size_t>(vertices[i]);
      velocity[v] = values[4 * i];
      product[v] = sheet.model.mass()[v] * velocity[v];
      largest = std::max(largest, std::abs(velocity[v]));
    }
    cluster->for_each_added([&](mesh::VertexId i, mesh::VertexId j, double entry) {
      const auto a = static_cast<std::size_t>(i);
      const auto b = static_cast<std::size_t>(j);
      product[a] += entry * velocity[b];
      if (a != b) product[b] += entry * velocity[a];
    });
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const double given = 0.25 * static_cast<double>(4 * i % 7) - 0.5;
      EXPECT_NEAR(product[static_cast<std::size_t>(vertices[i])], given, 1e-9);
      EXPECT_NEAR(static_cast<double>(rounded[4 * i]), values[4 * i], 1e-4 * largest);
    }
  }
}

TEST(LocalInertia, ClustersSolveAsBeforeOnceNothingIsHeldAnyMore) {
  const CutSheet sheet(20);
  ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
  integrator.rebuild(sheet.model);
  ASSERT_GT(integrator.inertia().clusters().size(), 5U);
  for (InertiaCluster* const cluster : integrator.inertia().clusters()) {
    const std::size_t n = cluster->vertices().size();
    const auto solved = [&] {
      std::vector<linear::Lanes16<float>> lanes(n / 4 + 1);
      float* const values = lanes.front().lane.data();
      for (std::size_t i = 0; i < 4 * n; ++i) values[i] = 0.25F * static_cast<float>(i % 7) - 0.5F;
      cluster->solve(values);
      return std::vector<float>(values, values + 4 * n);
    };
    const std::vector<float> before = solved();
    std::vector<std::uint8_t> held(n, 0);
    held[0] = 0b111;
    cluster->hold(held);
    const std::vector<float> with_pin = solved();
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(with_pin[c], 0.0F);
    EXPECT_NE(with_pin, before);
    held[0] = 0;
    cluster->hold(held);
    EXPECT_EQ(solved(), before);
  }
}

// Two cuts of seed 28 meet by the edge that is held, where a membrane with clusters erred by 0.67 mm. Ten of seed 1
// take triangles into clusters.
TEST_P(LocalInertiaOf, FallsAsPlainLeapfrogDoes) {
  struct Case {
    std::uint64_t seed;
    std::size_t num_cuts;
    double times_fewer_substeps;
    double p99, largest;  // m
  };
  Material material = *find_preset("demo");
  material.stiffness_damping = 8.3e-6;
  for (const Case& each : {Case{28, 2, 1.0, 1e-6, 5e-5}, Case{1, 10, 3.0, 1e-5, 5e-5}}) {
    CutSheet sheet(each.num_cuts, material, each.seed);
    State start = rest_state(sheet.mesh);
    for (Eigen::Index v = 0; v < start.x.cols(); ++v) {
      start.x(2, v) = 1e-3 * std::sin(9.0 * start.x(0, v)) * std::cos(7.0 * start.x(1, v));
    }
    const Loads loads = each.num_cuts == 2 ? sheet.pinned_at_top(start) : sheet.pinned_at_corners();
    ExplicitIntegrator plain(explicit_options(Precision::kDouble, false));
    plain.rebuild(sheet.model);
    ExplicitIntegrator clustered(explicit_options(GetParam()));
    clustered.rebuild(sheet.model);
    ASSERT_FALSE(clustered.inertia().empty());
    ASSERT_LE(each.times_fewer_substeps * clustered.planned_substeps(kTick), plain.planned_substeps(kTick));
    const State expected = stepped(sheet.model, plain, start, loads, 3);
    const State found = stepped(sheet.model, clustered, start, loads, 3);
    std::vector<double> errors;
    for (Eigen::Index v = 0; v < found.x.cols(); ++v) errors.push_back((found.x.col(v) - expected.x.col(v)).norm());
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() * 99 / 100], each.p99) << each.num_cuts << " cuts";
    EXPECT_LT(errors.back(), each.largest) << each.num_cuts << " cuts";
  }
}

TEST_P(LocalInertiaOf, FreeFallIsExactAtEveryVertex) {
  CutSheet sheet(20);
  ExplicitIntegrator integrator(explicit_options(GetParam()));
  integrator.rebuild(sheet.model);
  ASSERT_GT(integrator.inertia().clusters().size(), 5U);
  const State start = rest_state(sheet.mesh);
  const State state = stepped(sheet.model, integrator, start, Loads(), 30);
  double largest = 0.0;
  for (mesh::VertexId v = 0; v < sheet.mesh.num_vertices(); ++v) {
    if (!sheet.mesh.has_material(v)) continue;
    largest = std::max(largest, (state.x.col(v) - start.x.col(v)).head<2>().norm());
    largest = std::max(largest, std::abs(state.x(2, v) - state.x(2, 0)));
  }
  // Nothing moves in the plane, and all vertices are as low as the first. Rounding of positions in mixed precision
  // turns flakes of a tenth of a millimetre about.
  EXPECT_LT(largest, GetParam() == Precision::kDouble ? 1e-11 : 2e-4);
}

// Rounding of forces that are large beside a flake's weight threw one of 50 micrograms away at 4 m/s.
TEST(LocalInertia, FlakesFallWithTheSheet) {
  CutSheet sheet(50, *find_preset("demo"), 14159265);
  ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
  integrator.rebuild(sheet.model);
  const State start = rest_state(sheet.mesh);
  const State state = stepped(sheet.model, integrator, start, Loads(), 4);
  int num_flakes = 0;
  for (const InertiaCluster* const cluster : integrator.inertia().clusters()) {
    if (!cluster->is_piece()) continue;
    ++num_flakes;
    Eigen::Vector3d moved = Eigen::Vector3d::Zero();
    double total = 0.0;
    for (const mesh::VertexId v : cluster->vertices()) {
      const double mass = sheet.model.mass()[static_cast<std::size_t>(v)];
      moved += mass * (state.x.col(v) - start.x.col(v));
      total += mass;
    }
    EXPECT_LT((moved / total - Eigen::Vector3d(0.0, 0.0, state.x(2, 0) - start.x(2, 0))).norm(), 1e-6);
  }
  EXPECT_GT(num_flakes, 3);
}

// Kicks of bending longer than its clusters are made for let noise grow to 1e-8 m in this time, and without an end.
TEST(LocalInertia, NoiseInFreeFallDoesNotGrow) {
  CutSheet sheet(50, *find_preset("demo"), 3);
  ExplicitIntegrator integrator(explicit_options(Precision::kDouble));
  integrator.rebuild(sheet.model);
  const State start = rest_state(sheet.mesh);
  const int num_ticks = test::num_trials({.few = 4, .usual = 40, .many = 160});
  const State state = stepped(sheet.model, integrator, start, Loads(), num_ticks);
  double largest = 0.0;
  for (mesh::VertexId v = 0; v < sheet.mesh.num_vertices(); ++v) {
    if (sheet.mesh.has_material(v)) largest = std::max(largest, (state.x.col(v) - start.x.col(v)).head<2>().norm());
  }
  EXPECT_LT(largest, 1e-10);
}

TEST_P(LocalInertiaOf, KeepsMomentumOfATumblingSheet) {
  Material material = *find_preset("demo");
  material.mass_damping = 0.0;
  material.stiffness_damping = 0.0;  // damped bending brakes the spin of a bent sheet
  CutSheet sheet(20, material);
  ExplicitIntegrator integrator(explicit_options(GetParam()));
  integrator.rebuild(sheet.model);
  State state = rest_state(sheet.mesh);
  const Eigen::Vector3d omega(1.0, -2.0, 4.0);
  for (Eigen::Index v = 0; v < state.x.cols(); ++v) {
    const Eigen::Vector3d x = state.x.col(v);
    state.v.col(v) = omega.cross(x) + Eigen::Vector3d(0.0, 0.0, 0.3 * std::sin(6.0 * x.x()));
  }
  const auto momentum_of = [&](const State& at) {
    Momentum momentum = sheet.model.momentum(at);
    momentum.angular += integrator.inertia().added_spin(at);
    return momentum;
  };
  const Momentum before = momentum_of(state);
  const double energy = energy_of(sheet.model, integrator, state, no_forces());
  state = stepped(sheet.model, integrator, state, no_forces(), 30);
  const Momentum after = momentum_of(state);
  EXPECT_LT((after.linear - before.linear).norm(), 1e-9);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-9);
  EXPECT_LT(energy_of(sheet.model, integrator, state, no_forces()), 1.0001 * energy);
}

// Cut by cut, and undo by undo, an integrator that follows makes the same bits as a new one.
TEST_P(LocalInertiaOf, FollowsCutsAndUndosAsIfBuiltAnew) {
  CutSheet sheet(0);
  ExplicitIntegrator following(explicit_options(GetParam()));
  following.rebuild(sheet.model);
  const auto compare = [&](int step) {
    ExplicitIntegrator fresh(explicit_options(GetParam()));
    fresh.rebuild(sheet.model);
    ASSERT_EQ(following.inertia().num_vertices(), fresh.inertia().num_vertices()) << step;
    ASSERT_EQ(following.inertia().num_entries(), fresh.inertia().num_entries()) << step;
    const Loads loads = sheet.pinned_at_corners();
    State a = rest_state(sheet.mesh);
    State b = a;
    following.step(sheet.model, loads, 1e-3, nullptr, a);
    fresh.step(sheet.model, loads, 1e-3, nullptr, b);
    ASSERT_EQ(hash_of(a), hash_of(b)) << step;
  };
  const int num_cuts = test::num_trials({.few = 11, .usual = 16, .many = 30});
  for (int i = 0; i < num_cuts; ++i) {
    sheet.cuts.make_one();
    following.follow(sheet.model);
    compare(i);
  }
  EXPECT_FALSE(following.inertia().empty());
  for (int i = num_cuts; i-- > 0;) {
    sheet.cuts.undo_one();
    following.follow(sheet.model);
    compare(i);
  }
  EXPECT_TRUE(following.inertia().empty());
}

// The vertices of the largest cluster.
std::vector<mesh::VertexId> largest_cluster(const LocalInertia& inertia) {
  std::vector<mesh::VertexId> largest;
  for (const InertiaCluster* const cluster : inertia.clusters()) {
    const std::span<const mesh::VertexId> vertices = cluster->vertices();
    if (vertices.size() > largest.size()) largest.assign(vertices.begin(), vertices.end());
  }
  return largest;
}

TEST_P(LocalInertiaOf, HoldsPinsInAClusterWhollyAndByComponent) {
  CutSheet sheet(20);
  ExplicitIntegrator integrator(explicit_options(GetParam()));
  integrator.rebuild(sheet.model);
  const std::vector<mesh::VertexId> cluster = largest_cluster(integrator.inertia());
  ASSERT_GT(cluster.size(), 5U);
  const State start = rest_state(sheet.mesh);
  Loads loads;
  loads.pins.push_back({cluster[0], start.x.col(cluster[0])});
  loads.pins.push_back({cluster[3], start.x.col(cluster[3]), Eigen::Vector3d::Zero(), {false, false, true}});
  const State state = stepped(sheet.model, integrator, start, loads, 12);
  EXPECT_EQ((state.x.col(cluster[0]) - start.x.col(cluster[0])).norm(), 0.0);
  EXPECT_EQ(state.x(2, cluster[3]), start.x(2, cluster[3]));
  EXPECT_NE(state.x(0, cluster[3]), start.x(0, cluster[3]));
  EXPECT_LT(state.x.row(2).minCoeff(), -0.05);  // the rest falls
  // Let go again, they fall with what is around them.
  const State later = stepped(sheet.model, integrator, state, Loads(), 6);
  EXPECT_LT(later.x(2, cluster[0]), -1e-3);
}

// The grabbed vertex may have a billionth of a kilogram.
TEST_P(LocalInertiaOf, IsPulledByAGrabInACluster) {
  CutSheet sheet(20);
  ExplicitIntegrator integrator(explicit_options(GetParam()));
  integrator.rebuild(sheet.model);
  const std::vector<mesh::VertexId> cluster = largest_cluster(integrator.inertia());
  const State start = rest_state(sheet.mesh);
  Loads loads = sheet.pinned_at_corners();
  Grab grab;
  grab.vertices[0] = cluster[cluster.size() / 2];
  grab.target = start.x.col(grab.vertices[0]) + Eigen::Vector3d(0.0, 0.0, 0.1);
  grab.velocity = Eigen::Vector3d(0.0, 0.0, 0.0);
  grab.stiffness = 1e3;
  grab.damping = 1.0;
  loads.grabs.push_back(grab);
  State state = start;
  for (int i = 0; i < 30; ++i) integrator.step(sheet.model, loads, kTick, nullptr, state);
  EXPECT_LT((state.x.col(grab.vertices[0]) - grab.target).norm(), 0.02);
  EXPECT_TRUE(state.x.allFinite());
}

TEST_P(LocalInertiaOf, NeverGainsEnergyAfterCuts) {
  const auto many = static_cast<std::size_t>(test::num_trials({.few = 12, .usual = 40, .many = 100}));
  for (const std::string_view name : {"demo", "skin"}) {
    for (const std::size_t num_cuts : {std::size_t{2}, many}) {
      CutSheet sheet(num_cuts, *find_preset(name), 2);
      ExplicitIntegrator integrator(explicit_options(GetParam()));
      integrator.rebuild(sheet.model);
      ASSERT_FALSE(integrator.inertia().empty());
      const Loads loads = sheet.pinned_at_corners();
      State state = rest_state(sheet.mesh);
      const double before = energy_of(sheet.model, integrator, state, loads);
      const double scale = sheet.model.masses().total() * 9.81;  // J, of a fall of 1 m
      for (int i = 0; i < test::num_trials({.few = 6, .usual = 24, .many = 120}); ++i) {
        const StepStats stats = integrator.step(sheet.model, loads, kTick, nullptr, state);
        ASSERT_EQ(stats.flags & (kFrozen | kWidened | kEnergyLimited), 0U)
            << name << ", " << num_cuts << ", step " << i;
        ASSERT_LT(energy_of(sheet.model, integrator, state, loads), before + 1e-4 * scale)
            << name << ", " << num_cuts << ", step " << i;
      }
    }
  }
}

// Materials without damping of their own, and those that bend like plates.
TEST_P(LocalInertiaOf, IsStableWithoutDampingOfTheMaterial) {
  Material undamped = *find_preset("demo");
  undamped.stiffness_damping = 0.0;
  for (const Material& material : {undamped, *find_preset("wool"), *find_preset("foil"), *find_preset("paper")}) {
    for (const std::size_t num_cuts : {2, 10}) {
      CutSheet sheet(num_cuts, material);
      ExplicitIntegrator integrator(explicit_options(GetParam()));
      integrator.rebuild(sheet.model);
      ASSERT_FALSE(num_cuts == 10 && integrator.inertia().empty());
      const Loads loads = sheet.pinned_at_corners();
      State state = rest_state(sheet.mesh);
      for (Eigen::Index v = 0; v < state.x.cols(); ++v) {
        state.x(2, v) = 1e-3 * std::sin(9.0 * state.x(0, v)) * std::cos(7.0 * state.x(1, v));
      }
      const double dt = 400.0 * kTick / integrator.planned_substeps(kTick);
      double before = energy_of(sheet.model, integrator, state, loads);
      for (int i = 0; i < test::num_trials({.few = 1, .usual = 6, .many = 40}); ++i) {
        const StepStats stats = integrator.step(sheet.model, loads, dt, nullptr, state);
        ASSERT_EQ(stats.flags, 0U) << num_cuts << " cuts, step " << i;
        const double after = energy_of(sheet.model, integrator, state, loads);
        ASSERT_LT(after, before + 1e-6 * sheet.model.masses().total()) << num_cuts << " cuts, step " << i;
        before = after;
      }
    }
  }
}

TEST_P(LocalInertiaOf, StepsWithoutAllocating) {
  if (!test::counts_allocations()) GTEST_SKIP() << "the sanitizer has its own malloc";
  CutSheet sheet(10);
  ExplicitIntegrator integrator(explicit_options(GetParam()));
  integrator.rebuild(sheet.model);
  Loads loads = sheet.pinned_at_corners();
  loads.pins.push_back({largest_cluster(integrator.inertia()).front(), Eigen::Vector3d(0.5, 0.5, 0.1)});
  State state = rest_state(sheet.mesh);
  const std::size_t before = test::num_allocations();
  integrator.step(sheet.model, loads, kTick, nullptr, state);
  EXPECT_EQ(test::num_allocations(), before);
}

}  // namespace
}  // namespace kerf::fem
