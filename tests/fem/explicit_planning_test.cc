// The steps that cut sheets are given, and what is said of their clusters.
#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>

#include "server/core/fem/step/explicit_integrator.h"
#include "tests/fem/cut_sheet.h"
#include "tests/fem/no_contact.h"

namespace kerf::fem {
namespace {

TEST(ExplicitPlanning, KeepsTheSubstepsOfACutSheetNearThoseOfTheUncutOne) {
  // Bounds of orthotropic laws with little shear stiffness lose more.
  struct Case {
    std::string_view name;
    double times_uncut;
  };
  for (const auto& [name, times_uncut] :
       {Case{"demo", 2.8}, Case{"skin", 2.8}, Case{"wool", 3.3}, Case{"cotton", 3.9}, Case{"paper", 4.0}}) {
    CutSheet sheet(0, *find_preset(name));
    ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
    integrator.rebuild(sheet.model);
    const double uncut = integrator.planned_substeps(kTick);
    EXPECT_TRUE(integrator.inertia().empty()) << name;
    for (const std::size_t num_cuts : {1, 5, 10, 20, 50}) {
      sheet.cuts.make(num_cuts);
      integrator.rebuild(sheet.model);
      EXPECT_LE(integrator.planned_substeps(kTick), times_uncut * uncut) << name << " after " << num_cuts;
    }
    EXPECT_FALSE(integrator.inertia().empty()) << name;
  }
}

// Only bending asks for clusters, so that it need not act in every substep.
TEST(ExplicitPlanning, FewCutsLeaveTheMembraneWithoutClusters) {
  CutSheet sheet(0, *find_preset("demo"), 2);
  ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
  integrator.rebuild(sheet.model);
  const auto num_stiff_triangles = [&] {
    std::ptrdiff_t count = 0;
    for (const InertiaCluster* const cluster : integrator.inertia().clusters()) {
      count += std::count_if(cluster->parts().begin(), cluster->parts().end(),
                             [](const StiffPart& part) { return part.is_triangle(); });
    }
    return count;
  };
  const auto plain_substeps = [&] {
    ExplicitIntegrator plain(explicit_options(Precision::kMixed, false));
    plain.rebuild(sheet.model);
    return plain.planned_substeps(kTick);
  };
  sheet.cuts.make(2);
  integrator.follow(sheet.model);
  const double after_two = integrator.planned_substeps(kTick);
  EXPECT_FALSE(integrator.inertia().empty());
  EXPECT_EQ(num_stiff_triangles(), 0);
  EXPECT_EQ(after_two, plain_substeps());
  EXPECT_EQ(integrator.bending_interval(kTick / after_two, 0.0), 3);
  while (sheet.cuts.size() < 10) {
    sheet.cuts.make_one();
    integrator.follow(sheet.model);
  }
  EXPECT_GT(num_stiff_triangles(), 0);
  EXPECT_LT(integrator.planned_substeps(kTick), plain_substeps());
  while (sheet.cuts.size() > 2) {
    sheet.cuts.undo_one();
    integrator.follow(sheet.model);
  }
  EXPECT_EQ(num_stiff_triangles(), 0);
  EXPECT_EQ(integrator.planned_substeps(kTick), after_two);
}

// Friction does not hold what bending or the fastest modes shake.
TEST(ExplicitPlanning, ACalmSheetNearBodiesTakesMoreSubstepsAndBendsInEach) {
  const mesh::TriangleMesh mesh = square_grid(20);
  const Model model(mesh, *find_preset("demo"));
  IntegratorOptions options = explicit_options(Precision::kMixed);
  const auto stats_of = [&](bool is_calm) {
    ExplicitIntegrator integrator(options);
    integrator.rebuild(model);
    NoContact contact(is_calm);
    State state = rest_state(mesh);
    return integrator.step(model, Loads(), kTick, &contact, state);
  };
  const StepStats plain = stats_of(false);
  const StepStats calm = stats_of(true);
  EXPECT_GT(plain.bending_interval, 1);
  EXPECT_EQ(calm.bending_interval, 1);
  EXPECT_GE(calm.substeps, 1.4 * plain.substeps);
  // The limit of substeps holds, and being calm makes no step too long for it.
  options.max_substeps = calm.substeps - 1;
  EXPECT_EQ(stats_of(true).substeps, options.max_substeps);
  EXPECT_EQ(stats_of(true).flags, 0U);
}

// Noise grew by decades a second where kicks were longer than what is stiff was chosen for.
TEST(ExplicitPlanning, BendingKicksAreNoLongerThanClustersAreMadeFor) {
  int num_with_clusters = 0;
  for (const int side : {13, 50}) {
    mesh::TriangleMesh mesh = square_grid(side);
    Model model(mesh, *find_preset("demo"));
    test::RandomCuts cuts(1, mesh, model);
    ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
    for (int i = 0; i < 12; ++i) {
      cuts.make_one();
      integrator.rebuild(model);
      if (integrator.inertia().empty()) continue;
      ++num_with_clusters;
      EXPECT_LE(integrator.bending_interval(kTick / integrator.planned_substeps(kTick), 0.0), 3) << side << ", " << i;
    }
  }
  EXPECT_GT(num_with_clusters, 12);
}

// Small sheets are those whose bending asks for shorter kicks than the membrane for steps.
TEST(ExplicitPlanning, UncutSheetsHaveNoClustersAndIrregularOnesSmallOnes) {
  std::size_t largest = 0;
  for (const std::string_view name : {"demo", "skin", "rubber", "wool"}) {
    for (const double size : {0.04, 0.05, 0.06, 0.071, 0.08, 0.1, 0.2, 1.0}) {
      ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
      integrator.rebuild(Model(square_grid(30, size), *find_preset(name)));
      EXPECT_TRUE(integrator.inertia().empty()) << name << ", " << size << " m";
      const Model jittered(jittered_square(20, size), *find_preset(name));
      integrator.rebuild(jittered);
      EXPECT_LT(integrator.inertia().num_vertices(), jittered.mass().size() / 3) << name << ", " << size << " m";
      EXPECT_TRUE(size < 1.0 || integrator.inertia().empty()) << name << ", " << size << " m";
      largest = std::max(largest, integrator.inertia().largest());
    }
  }
  EXPECT_GT(largest, 0U);
  EXPECT_LT(largest, 40U);
}

TEST(ExplicitPlanning, ReportsClustersAndTheSubstepsThatTheySave) {
  CutSheet sheet(0);
  ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
  integrator.rebuild(sheet.model);
  EXPECT_FALSE(integrator.local_inertia(kTick)) << "nothing is cut";
  while (sheet.cuts.size() < 10) {
    sheet.cuts.make_one();
    integrator.follow(sheet.model);
  }
  const std::optional<LocalInertiaStats> stats = integrator.local_inertia(kTick);
  ASSERT_TRUE(stats);
  const auto clusters = integrator.inertia().clusters();
  std::size_t vertices = 0, largest = 0;
  for (const InertiaCluster* cluster : clusters) {
    vertices += cluster->vertices().size();
    largest = std::max(largest, cluster->vertices().size());
  }
  EXPECT_EQ(stats->clusters, static_cast<int>(clusters.size()));
  EXPECT_EQ(stats->vertices, static_cast<int>(vertices));
  EXPECT_EQ(stats->largest, static_cast<int>(largest));
  ExplicitIntegrator plain(explicit_options(Precision::kMixed, false));
  plain.rebuild(sheet.model);
  EXPECT_FALSE(plain.local_inertia(kTick));
  EXPECT_EQ(stats->plain_substeps, plain.planned_substeps(kTick));
  EXPECT_EQ(stats->planned_substeps, integrator.planned_substeps(kTick));
  EXPECT_LT(2.0 * stats->planned_substeps, stats->plain_substeps);
  State state = rest_state(sheet.mesh);
  const StepStats step = integrator.step(sheet.model, sheet.pinned_at_corners(), kTick, nullptr, state);
  EXPECT_GE(step.substeps, stats->planned_substeps);
}

TEST(ExplicitPlanning, ClustersAreReportedByWhatRuns) {
  const CutSheet sheet(10);
  IntegratorOptions options;
  const auto found = [&](IntegratorKind kind) {
    options.kind = kind;
    const std::unique_ptr<Integrator> integrator = make_integrator(options);
    integrator->rebuild(sheet.model);
    EXPECT_NE(integrator->kind(), IntegratorKind::kAutomatic);
    return integrator->local_inertia(options.tick);
  };
  ASSERT_TRUE(found(IntegratorKind::kAutomatic));
  EXPECT_EQ(found(IntegratorKind::kAutomatic)->vertices, found(IntegratorKind::kExplicit)->vertices);
  EXPECT_FALSE(found(IntegratorKind::kTrBdf2));
  options.max_substeps = 1;
  EXPECT_FALSE(found(IntegratorKind::kAutomatic)) << "implicit where explicit steps would take too many substeps";
}

}  // namespace
}  // namespace kerf::fem
