// The cost of a tick from counts: parts, what raises them, and what integrators count of a sheet.
#include "server/core/fem/model/tick_cost.h"

#include "server/core/fem/step/automatic_integrator.h"
#include "tests/fem/cut_sheet.h"

namespace kerf::fem {
namespace {

const ExplicitCounts kExplicit{
    .substeps = 100.0, .bending_interval = 4.0, .slots = 5000.0, .bending_entries = 45'000.0, .vertices = 2500.0};

TEST(TickCost, EachCountRaisesItsPartAlone) {
  const TickCost base = cost_of(kExplicit, {});
  EXPECT_EQ(base[TickPart::kClusters], 0.0);
  EXPECT_EQ(base[TickPart::kContact], 0.0);
  EXPECT_EQ(base[TickPart::kLoads], 0.0);
  const auto expect_raised = [&](const ExplicitCounts& counts, const TickCounts& last, TickPart part) {
    const TickCost cost = cost_of(counts, last);
    for (std::size_t i = 0; i < cost.ns.size(); ++i) {
      const bool is_raised = i == static_cast<std::size_t>(part);
      EXPECT_EQ(cost.ns[i] > base.ns[i], is_raised) << kTickPartNames[i];
    }
    EXPECT_GT(cost.total(), base.total());
  };
  ExplicitCounts clustered = kExplicit;
  clustered.clusters = 10.0;
  expect_raised(clustered, {}, TickPart::kClusters);
  expect_raised(kExplicit, {.contact_blocks = 20.0}, TickPart::kContact);
  expect_raised(kExplicit, {.load_phases = 1.0}, TickPart::kLoads);
  EXPECT_EQ(base[TickPart::kSelfContact], 0.0);
  for (const SelfContactCounts& counts :
       {SelfContactCounts{.phases = 1.0}, SelfContactCounts{.searches = 1.0}, SelfContactCounts{.pairs = 1.0},
        SelfContactCounts{.contacts = 1.0}, SelfContactCounts{.repairs = 1.0}}) {
    expect_raised(kExplicit, {.self_contact = counts}, TickPart::kSelfContact);
  }
}

TEST(TickCost, BeforeTheFirstTickSelfContactLooksOnceInAWhileAndHasAnAllowance) {
  const SelfContactCounts few = expected_self_contact(10.0, 1000.0), many = expected_self_contact(160.0, 1000.0);
  EXPECT_EQ(few.phases, 2.0);
  EXPECT_EQ(many.phases, 11.0);
  EXPECT_EQ(few.contacts, 0.1 * 1000.0 * few.phases);
  EXPECT_EQ(expected_self_contact(0.0, 1000.0).phases, 5.0) << "implicit steps have parts";
  const ImplicitCounts implicit{.most_newton_iterations = 4.0, .vertices = 1000.0, .slots = 2000.0};
  EXPECT_EQ(cost_of(implicit, {.self_contact = many})[TickPart::kSelfContact],
            cost_of({.substeps = 160.0, .vertices = 1000.0}, {.self_contact = many})[TickPart::kSelfContact]);
}

TEST(TickCost, PushesCountWhereThereAreClusters) {
  const TickCounts pushed{.cluster_pushes = 2.0};
  EXPECT_EQ(cost_of(kExplicit, pushed)[TickPart::kContact], 0.0) << "they are of a sheet before an undo";
  ExplicitCounts clustered = kExplicit;
  clustered.clusters = 10.0;
  EXPECT_GT(cost_of(clustered, pushed)[TickPart::kContact], 0.0);
}

TEST(TickCost, ImplicitStepsCountTheIterationsOfTheLastTick) {
  const ImplicitCounts counts{
      .most_newton_iterations = 4.0, .vertices = 2500.0, .slots = 5000.0, .solver = SystemSolver::kKeptFactor};
  const double most = cost_of(counts, {}).total();
  EXPECT_EQ(cost_of(counts, {.newton_iterations = 4.0}).total(), most);
  EXPECT_EQ(cost_of(counts, {.newton_iterations = 2.0}).total(), 0.5 * most);
  ImplicitCounts iterative = counts;
  iterative.solver = SystemSolver::kIterative;
  const auto of_iterations = [&](double linear) {
    return cost_of(iterative, {.newton_iterations = 2.0, .linear_iterations = linear})[TickPart::kSolve];
  };
  EXPECT_EQ(of_iterations(200.0), 2.0 * of_iterations(100.0));
}

TEST(TickCost, ExplicitStepsCountTheirPlan) {
  const double tick = 1.0 / 60.0;
  const CutSheet uncut(0);
  const CutSheet cut(20);
  ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
  integrator.rebuild(uncut.model);
  const TickCost before = integrator.expected_cost(uncut.model, tick, {});
  EXPECT_EQ(before.substeps, integrator.planned_substeps(tick));
  EXPECT_EQ(before[TickPart::kClusters], 0.0);
  integrator.rebuild(cut.model);
  const TickCost after = integrator.expected_cost(cut.model, tick, {});
  EXPECT_GT(after[TickPart::kClusters], 0.0);
  EXPECT_GT(after.total(), 2.0 * before.total());
}

TEST(TickCost, AutomaticCountsTheIntegratorThatRuns) {
  IntegratorOptions options;
  options.newton_iterations = 2;
  const auto kind_of = [&](const Model& model) {
    const std::unique_ptr<Integrator> integrator = make_integrator(options);
    integrator->rebuild(model);
    const TickEstimate estimate = estimate_tick(model, options);
    EXPECT_EQ(estimate.is_explicit, integrator->kind() == IntegratorKind::kExplicit);
    const double counted = estimate.is_explicit ? estimate.explicit_ns : estimate.implicit_ns;
    EXPECT_EQ(integrator->expected_cost(model, options.tick, {}).total(), counted);
    return integrator->kind();
  };
  Material stiff = *find_preset("foil");
  EXPECT_EQ(kind_of(Model(square_grid(50), stiff)), IntegratorKind::kExplicit);
  stiff.youngs_modulus_1 *= 4.0;
  stiff.youngs_modulus_2 *= 4.0;
  stiff.shear_modulus *= 4.0;
  EXPECT_EQ(kind_of(Model(square_grid(50), stiff)), IntegratorKind::kTrBdf2);
  const CutSheet cut(10, *find_preset("foil"));
  EXPECT_NE(kind_of(cut.model), IntegratorKind::kExplicit) << "with local inertia all iterations count";
}

}  // namespace
}  // namespace kerf::fem
