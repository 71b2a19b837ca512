// Tests the choice of the automatic integrator, and that sheets stay accurate by it.
#include <cmath>
#include <utility>
#include <vector>

#include "server/core/cut/cut.h"
#include "server/core/fem/step/automatic_integrator.h"
#include "tests/fem/integrator_cases.h"
#include "tests/support/random_cuts.h"

namespace kerf::fem {
namespace {

mesh::TriangleMesh cut_at_random(int side, int cuts) {
  mesh::TriangleMesh mesh = square_grid(side);
  SeededRandom random(14159265);  // the first decimals of pi
  for (int made = 0; made < cuts;) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {test::random_cubic(random), {}, {}});
    if (!plan.ok()) continue;
    const Result<cut::CutOutcome> outcome = cut::apply(mesh, *plan);
    made += outcome.ok() && outcome->status == cut::CutStatus::kApplied ? 1 : 0;
  }
  return mesh;
}

IntegratorOptions as_it_comes(AutomaticChoice choice = AutomaticChoice::kSecond) {
  IntegratorOptions options;
  options.newton_iterations = 2;  // as a new sheet has it
  options.choice = choice;
  return options;
}

struct Swing {
  IntegratorKind kind;
  State end;
};
// Swings a sheet from its upper edge for 0.1 s, `parts` steps a tick.
Swing swing(const mesh::TriangleMesh& mesh, const Model& model, const IntegratorOptions& options, int parts) {
  State state = rest_state(mesh);
  Loads loads;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.rest_position(v).y() > 1.0 - 1e-9) loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  }
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  for (int i = 0; i < 6 * parts; ++i) integrator->step(model, loads, kTick / parts, nullptr, state);
  return {integrator->kind(), state};
}

double rms(const State& found, const State& expected) {
  return (found.x - expected.x).norm() / std::sqrt(static_cast<double>(found.x.cols()));
}

// Random cuts cross and leave slivers. The sheet is far too stiff then for explicit steps in real time.
TEST(AutomaticIntegrator, KeepsTheSwingOfStiffSheetsAfterManyCuts) {
  const mesh::TriangleMesh mesh = cut_at_random(12, 30);
  // Paper is just below the condition number from which on SDIRK2 is taken.
  for (const auto& [material, kind] :
       {std::pair{"wool", IntegratorKind::kSdirk2}, std::pair{"paper", IntegratorKind::kTrBdf2}}) {
    const Model model(mesh, find_preset(material).value());
    IntegratorOptions fine;
    fine.kind = IntegratorKind::kBdf2;
    fine.linear_solver = linear::LinearSolverKind::kDirect;
    const Swing expected = swing(mesh, model, fine, 16);
    const Swing found = swing(mesh, model, as_it_comes(), 1);
    const Swing before = swing(mesh, model, as_it_comes(AutomaticChoice::kFirst), 1);
    std::printf("%s: %.2g mm off, %.2g mm by the first choice\n", material, 1e3 * rms(found.end, expected.end),
                1e3 * rms(before.end, expected.end));
    EXPECT_EQ(found.kind, kind);
    EXPECT_EQ(before.kind == IntegratorKind::kImplicitEuler, kind == IntegratorKind::kSdirk2);
    EXPECT_LT(rms(found.end, expected.end), 5e-4);
    EXPECT_LT(rms(found.end, expected.end), 0.2 * rms(before.end, expected.end));
  }
}

TEST(AutomaticIntegrator, TakesExplicitStepsThatFitTheTickWhateverElseIsFaster) {
  const mesh::TriangleMesh mesh = cut_at_random(12, 15);
  const Model model(mesh, find_preset("wool").value());
  const TickEstimate estimate = estimate_tick(model, as_it_comes());
  EXPECT_LT(estimate.explicit_ns, 1e9 * kShareOfTick * kTick);
  EXPECT_GT(estimate.explicit_ns, 1.5 * estimate.implicit_ns);
  EXPECT_TRUE(estimate.is_explicit);
  EXPECT_FALSE(estimate_tick(model, as_it_comes(AutomaticChoice::kFirst)).is_explicit);
  // In a tick of a quarter the estimate of explicit steps is a quarter, too, and fits as well as before.
  IntegratorOptions shorter = as_it_comes();
  shorter.tick = 0.25 * kTick;
  EXPECT_TRUE(estimate_tick(model, shorter).is_explicit);
  // A finer sheet does not fit.
  const mesh::TriangleMesh fine = cut_at_random(40, 10);
  EXPECT_FALSE(estimate_tick(Model(fine, find_preset("wool").value()), as_it_comes()).is_explicit);
}

TEST(AutomaticIntegrator, CountsAllIterationsThatCutSheetsMayNeed) {
  const auto wool = find_preset("wool").value();
  const mesh::TriangleMesh uncut = square_grid(12);
  const mesh::TriangleMesh cut = cut_at_random(12, 15);
  const auto implicit_ns = [&](const mesh::TriangleMesh& mesh, AutomaticChoice choice, bool touches_itself = false) {
    IntegratorOptions options = as_it_comes(choice);
    options.touches_itself = touches_itself;
    return estimate_tick(Model(mesh, wool), options).implicit_ns;
  };
  EXPECT_GT(implicit_ns(cut, AutomaticChoice::kSecond), 1.5 * implicit_ns(cut, AutomaticChoice::kFirst));
  EXPECT_EQ(implicit_ns(uncut, AutomaticChoice::kSecond), implicit_ns(uncut, AutomaticChoice::kFirst));
  EXPECT_EQ(implicit_ns(cut, AutomaticChoice::kSecond, true), implicit_ns(cut, AutomaticChoice::kFirst))
      << "the limit with self-contact was found without them";
}

// The stiffness changes the number of substeps alone. It is bisected to where the choice changes.
TEST(AutomaticIntegrator, ChoosesByTheRatioOfCosts) {
  const auto expect_limit = [](const mesh::TriangleMesh& mesh, double limit) {
    const auto estimate_at = [&](double stiffness) {
      return estimate_tick(Model(mesh, isotropic(stiffness, 0.3, 5.0e-4, 200.0)), as_it_comes());
    };
    const auto ratio_of = [](const TickEstimate& estimate) { return estimate.explicit_ns / estimate.implicit_ns; };
    double soft = 1e4, stiff = 1e12;  // Pa
    while (stiff > 1.01 * soft) {
      const double middle = std::sqrt(soft * stiff);
      (estimate_at(middle).is_explicit ? soft : stiff) = middle;
    }
    EXPECT_GT(estimate_at(soft).explicit_ns, 1e9 * kShareOfTick * kTick) << "it is no choice of those that fit";
    EXPECT_LE(ratio_of(estimate_at(soft)), limit);
    EXPECT_GT(ratio_of(estimate_at(soft)), 0.98 * limit);
    EXPECT_GT(ratio_of(estimate_at(stiff)), limit);
    EXPECT_LT(ratio_of(estimate_at(stiff)), 1.02 * limit);
  };
  expect_limit(square_grid(50), 6.0);
  expect_limit(cut_at_random(50, 5), 1.0);
}

TEST(AutomaticIntegrator, TakesImplicitEulerNowhere) {
  for (const int cuts : {0, 10, 50}) {
    const mesh::TriangleMesh mesh = cut_at_random(10, cuts);
    for (const std::string_view material : preset_names()) {
      const std::unique_ptr<Integrator> integrator = make_integrator(as_it_comes());
      integrator->rebuild(Model(mesh, find_preset(material).value()));
      EXPECT_NE(integrator->kind(), IntegratorKind::kImplicitEuler) << material << " after " << cuts << " cuts";
    }
  }
}

TEST(AutomaticIntegrator, TakesExplicitUnlessSheetsAreStiffAndSaysWhy) {
  const mesh::TriangleMesh mesh = square_grid(20);
  IntegratorOptions options;
  options.newton_iterations = 2;  // as a new sheet has it
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  const Model soft(mesh, soft_cloth());
  integrator->rebuild(soft);
  EXPECT_EQ(integrator->kind(), IntegratorKind::kExplicit);
  EXPECT_NE(integrator->explanation().find("substeps in mixed precision"), std::string_view::npos);
  const Model stiff(mesh, isotropic(5.0e11, 0.3, 5.0e-4, 1000.0));
  integrator->rebuild(stiff);
  EXPECT_EQ(integrator->kind(), IntegratorKind::kTrBdf2);
  EXPECT_NE(integrator->explanation().find("TR-BDF2, direct"), std::string_view::npos);
  const Model beyond(mesh, isotropic(1.0e13, 0.3, 5.0e-4, 1000.0));
  integrator->rebuild(beyond);
  EXPECT_EQ(integrator->kind(), IntegratorKind::kSdirk2);
  EXPECT_NE(integrator->explanation().find("SDIRK2, direct"), std::string_view::npos);
  EXPECT_NE(integrator->explanation().find("condition number above 1e9"), std::string_view::npos);
  State state = rest_state(mesh);
  EXPECT_EQ(integrator->step(beyond, Loads{}, kTick, nullptr, state).substeps, 1);
}

TEST(AutomaticIntegrator, PrefersExplicitForContactWithItself) {
  const mesh::TriangleMesh mesh = square_grid(20);
  IntegratorOptions options;
  options.newton_iterations = 2;  // as a new sheet has it
  const auto kind_of = [&](double youngs_modulus, bool touches_itself) {
    options.touches_itself = touches_itself;
    const std::unique_ptr<Integrator> integrator = make_integrator(options);
    const Model model(mesh, isotropic(youngs_modulus, 0.3, 5.0e-4, 1000.0));
    integrator->rebuild(model);
    const bool says = integrator->explanation().find("explicit, preferred for self-contact") != std::string_view::npos;
    EXPECT_EQ(says, touches_itself && integrator->kind() == IntegratorKind::kExplicit) << integrator->explanation();
    EXPECT_EQ(estimate_tick(model, options).is_explicit, integrator->kind() == IntegratorKind::kExplicit);
    return integrator->kind();
  };
  for (const bool touches_itself : {false, true}) EXPECT_EQ(kind_of(1.0e5, touches_itself), IntegratorKind::kExplicit);
  EXPECT_EQ(kind_of(5.0e11, false), IntegratorKind::kTrBdf2);
  EXPECT_EQ(kind_of(5.0e11, true), IntegratorKind::kExplicit);
  EXPECT_EQ(kind_of(1.0e14, true), IntegratorKind::kSdirk2);
}

TEST(AutomaticIntegrator, GoesFromExplicitToImplicitByACutAndBack) {
  mesh::TriangleMesh mesh = square_grid(20);
  const mesh::TriangleMesh before = mesh;
  Model model(mesh, soft_cloth());
  State state = rest_state(mesh);
  const std::unique_ptr<Integrator> uncut = make_integrator({});
  uncut->rebuild(model);
  IntegratorOptions options;
  options.max_substeps = uncut->step(model, Loads{}, kTick, nullptr, state).substeps * 11 / 10;
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  const auto expect_bits_of_a_fresh_start = [&](const mesh::TriangleMesh& now, IntegratorKind kind) {
    EXPECT_EQ(integrator->kind(), kind) << integrator->explanation();
    const std::unique_ptr<Integrator> fresh = make_integrator(options);
    fresh->rebuild(model);
    State followed = rest_state(now);
    State made = followed;
    for (int i = 0; i < 3; ++i) {
      integrator->prepare();
      EXPECT_EQ(integrator->step(model, Loads{}, kTick, nullptr, followed).flags & kFrozen, 0U);
      fresh->step(model, Loads{}, kTick, nullptr, made);
    }
    EXPECT_TRUE(equal_bits(followed, made));
  };
  expect_bits_of_a_fresh_start(mesh, IntegratorKind::kExplicit);

  const Result<cut::CutPlan> plan = cut::plan(mesh, {cut::Polyline{{{0.2, 0.37}, {0.83, 0.41}}}, {}, {}});
  ASSERT_TRUE(plan.ok());
  Result<cut::CutOutcome> outcome = cut::apply(mesh, *plan);
  ASSERT_TRUE(outcome.ok());
  std::vector<mesh::TriangleId> rewritten = outcome->edit.rewritten_triangles;
  model.follow(mesh, rewritten);
  integrator->follow(model);
  expect_bits_of_a_fresh_start(mesh, IntegratorKind::kTrBdf2);

  std::erase_if(rewritten, [&](mesh::TriangleId slot) { return slot >= before.num_triangle_slots(); });
  model.follow(before, rewritten);
  integrator->follow(model);
  expect_bits_of_a_fresh_start(before, IntegratorKind::kExplicit);
}

// The solver is chosen with the size: the bits are those of TR-BDF2 with the one that is asked for.
TEST(AutomaticIntegrator, SolvesLargeSheetsWithTheFloatFactor) {
  IntegratorOptions options;
  options.max_substeps = 1000;
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  mesh::TriangleMesh mesh = mesh::make_grid({.num_x = 44, .num_y = 45}).value();
  Model model(mesh, isotropic(1.0e10, 0.3, 5.0e-4, 1000.0));
  integrator->rebuild(model);
  const auto expect_bits_of = [&](linear::LinearSolverKind solver) {
    IntegratorOptions asked;
    asked.kind = IntegratorKind::kTrBdf2;
    asked.linear_solver = solver;
    const std::unique_ptr<Integrator> expected = make_integrator(asked);
    expected->rebuild(model);
    integrator->prepare();
    State state = rest_state(mesh);
    Loads loads;
    for (const int corner : {0, 43}) loads.pins.push_back({corner, state.x.col(corner), Eigen::Vector3d::Zero()});
    State other = state;
    integrator->step(model, loads, kTick, nullptr, state);
    expected->step(model, loads, kTick, nullptr, other);
    EXPECT_TRUE(equal_bits(state, other)) << integrator->explanation();
    EXPECT_NE(integrator->explanation().find(linear::name_of(solver).description), std::string_view::npos);
  };
  ASSERT_LT(model.num_vertices(), 2000);
  expect_bits_of(linear::LinearSolverKind::kDirect);
  const Result<cut::CutPlan> plan = cut::plan(mesh, {cut::Polyline{{{0.2, 0.37}, {0.83, 0.41}}}, {}, {}});
  ASSERT_TRUE(plan.ok());
  Result<cut::CutOutcome> outcome = cut::apply(mesh, *plan);
  ASSERT_TRUE(outcome.ok());
  model.follow(mesh, outcome->edit.rewritten_triangles);
  integrator->follow(model);
  ASSERT_GE(model.num_vertices(), 2000);
  expect_bits_of(linear::LinearSolverKind::kFactorCg);
}

}  // namespace
}  // namespace kerf::fem
