// Clusters with local inertia on cut sheets whose rest shape is curved.
#include <algorithm>
#include <cmath>
#include <vector>

#include "server/core/fem/model/stiff_parts.h"
#include "server/core/fem/step/explicit_integrator.h"
#include "tests/fem/cut_sheet.h"
#include "tests/support/shells.h"

namespace kerf::fem {
namespace {

struct CutShell {
  CutShell(std::size_t num_cuts, const mesh::IndexedMesh& sheet, const Material& material)
      : mesh(test::must(mesh::import_mesh(sheet))), model(mesh, material), cuts(3, mesh, model) {
    cuts.make(num_cuts);
  }
  [[nodiscard]] Loads pinned_at_one_side() const {
    Loads loads;
    const State rest = rest_on_surface(mesh);
    for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
      if (mesh.has_material(v) && mesh.rest_position(v).y() > 1.0 - 1e-9) loads.pins.push_back({v, rest.x.col(v)});
    }
    return loads;
  }
  mesh::TriangleMesh mesh;
  Model model;
  test::RandomCuts cuts;
};

CutShell cut_roll(std::size_t num_cuts, const Material& material = *find_preset("demo")) {
  return {num_cuts, test::rolled_square(40, 0.3), material};
}

// v.(sum of all stiff parts) v, J/s^2 kg, as the clusters would have it.
double bound_by_parts(const Model& model, const linear::VertexField& v) {
  std::vector<StiffPart> all;
  std::vector<PartAtVertex> found;
  std::vector<mesh::TriangleId> slots;
  const auto append = [&] {
    for (const PartAtVertex& each : found) all.push_back(each.part);
  };
  for (mesh::VertexId at = 0; at < model.num_vertices(); ++at) {
    find_triangles_at(model, at, found);
    append();
    find_bending_at(model, at, slots, found);
    append();
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  double sum = 0.0;
  for (const StiffPart& part : all) {
    const StiffPart::Matrix matrix = part.matrix(model);
    for (std::size_t a = 0; a < StiffPart::kMaxVertices; ++a) {
      double row = 0.0;
      for (std::size_t b = 0; b < StiffPart::kMaxVertices; ++b) {
        if (matrix.vertex[a] == mesh::kNone || matrix.vertex[b] == mesh::kNone) continue;
        row += matrix.value[a][b];
        sum += matrix.value[a][b] * v.col(matrix.vertex[a]).dot(v.col(matrix.vertex[b]));
      }
      EXPECT_NEAR(row, 0.0, 1e-9 * std::abs(matrix.value[a][a]) + 1e-12) << "a common motion has no stiffness";
    }
  }
  return sum;
}

// v.K v at rest, from differences of forces.
double stiffness_at_rest(const Model& model, const linear::VertexField& rest, const linear::VertexField& v) {
  constexpr double kStep = 1e-7;  // s
  linear::VertexField ahead(rest.cols()), behind(rest.cols());
  model.internal_forces(rest + kStep * v, ahead);
  model.internal_forces(rest - kStep * v, behind);
  return (behind - ahead).cwiseProduct(v).sum() / (2.0 * kStep);
}

TEST(ShellInertia, StiffPartsBoundTheStiffness) {
  SeededRandom random(4);
  for (const mesh::IndexedMesh& sheet :
       {test::rolled_square(9, 0.3), test::dome(9, 1.1, true), test::creased_sheet(9)}) {
    Material material = *find_preset("demo");
    material.thickness = 0.3;  // so that bending decides
    const CutShell shell(4, sheet, material);
    const linear::VertexField rest = rest_on_surface(shell.mesh).x;
    for (int i = 0; i < 40; ++i) {
      linear::VertexField v = random_field(random, rest.cols(), 1.0);
      // Every other field turns facets without bending a flat patch.
      const Eigen::Matrix3d map = random_field(random, 3, 1.0);
      if (i % 2 == 1) {
        for (Eigen::Index k = 0; k < v.cols(); ++k) v.col(k) = map * Eigen::Vector3d(rest.col(k));
      }
      EXPECT_LE(stiffness_at_rest(shell.model, rest, v), (1.0 + 1e-6) * bound_by_parts(shell.model, v)) << i;
    }
  }
}

TEST(ShellInertia, KeepsTheSubstepsOfACutShellNearThoseOfTheUncutOne) {
  CutShell shell = cut_roll(0);
  ExplicitIntegrator integrator(explicit_options(Precision::kMixed));
  integrator.rebuild(shell.model);
  const double uncut = integrator.planned_substeps(kTick);
  EXPECT_TRUE(integrator.inertia().empty());
  for (const std::size_t num_cuts : {5, 10, 20}) {
    shell.cuts.make(num_cuts);
    integrator.rebuild(shell.model);
    EXPECT_LE(integrator.planned_substeps(kTick), 4.2 * uncut) << num_cuts;
  }
  EXPECT_FALSE(integrator.inertia().empty());
  ExplicitIntegrator plain(explicit_options(Precision::kMixed, false));
  plain.rebuild(shell.model);
  EXPECT_GT(plain.planned_substeps(kTick), 8.0 * uncut);
}

TEST(ShellInertia, MovesAsPlainLeapfrogDoes) {
  const CutShell cut = cut_roll(5);
  Material material = *find_preset("demo");
  material.stiffness_damping = 0.2 / std::sqrt(cut.model.stiffness_bound().value());  // so that both have the same
  const Model model(cut.mesh, material);
  std::vector<State> results;
  for (const bool has_local_inertia : {false, true}) {
    ExplicitIntegrator integrator(explicit_options(Precision::kDouble, has_local_inertia));
    integrator.rebuild(model);
    EXPECT_EQ(integrator.inertia().empty(), !has_local_inertia);
    State state = rest_on_surface(cut.mesh);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(integrator.step(model, cut.pinned_at_one_side(), kTick, nullptr, state).flags, 0U);
    }
    results.push_back(state);
  }
  std::vector<double> errors;  // m
  for (Eigen::Index v = 0; v < results[0].x.cols(); ++v) {
    errors.push_back((results[0].x.col(v) - results[1].x.col(v)).norm());
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_GT((results[0].x - rest_on_surface(cut.mesh).x).cwiseAbs().maxCoeff(), 5e-3);
  EXPECT_LT(errors.back(), 1e-4);
  EXPECT_LT(errors[errors.size() * 99 / 100], 2e-5);
}

class ShellInertiaOf : public testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(EachPrecision, ShellInertiaOf, testing::Values(Precision::kDouble, Precision::kMixed),
                         [](const auto& tested) { return tested.param == Precision::kDouble ? "Double" : "Mixed"; });

TEST_P(ShellInertiaOf, NeverGainsEnergyAndKeepsMomentum) {
  Material material = *find_preset("demo");
  material.mass_damping = 0.0;
  const CutShell shell = cut_roll(10, material);
  ExplicitIntegrator integrator(explicit_options(GetParam()));
  integrator.rebuild(shell.model);
  ASSERT_FALSE(integrator.inertia().empty());
  Loads loads;  // tumbles freely
  loads.gravity.setZero();
  State state = rest_on_surface(shell.mesh);
  for (Eigen::Index v = 0; v < state.x.cols(); ++v) {
    state.v.col(v) = Eigen::Vector3d(1.0, 2.0, 0.5).cross(Eigen::Vector3d(state.x.col(v)));
    state.v(2, v) += 0.3 * std::sin(9.0 * state.x(0, v)) * std::cos(7.0 * state.x(1, v));
  }
  const auto momentum = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (Eigen::Index v = 0; v < state.v.cols(); ++v) {
      sum += shell.model.mass()[static_cast<std::size_t>(v)] * state.v.col(v);
    }
    return sum;
  };
  const auto energy = [&] {
    return shell.model.energies(state, loads.gravity).total() + integrator.inertia().added_energy(state.v);
  };
  const Eigen::Vector3d before = momentum();
  double highest = energy();
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(integrator.step(shell.model, loads, kTick, nullptr, state).flags, 0U) << i;
    EXPECT_LT(energy(), 1.0001 * highest) << i;
    highest = std::min(highest, energy());
  }
  EXPECT_LT((momentum() - before).norm(), 1e-8);
}

TEST_P(ShellInertiaOf, FollowsCutsAndUndosAsIfBuiltAnew) {
  CutShell shell = cut_roll(0);
  ExplicitIntegrator followed(explicit_options(GetParam()));
  followed.rebuild(shell.model);
  const auto expect_equal_steps = [&] {
    ExplicitIntegrator fresh(explicit_options(GetParam()));
    fresh.rebuild(shell.model);
    State a = rest_on_surface(shell.mesh);
    State b = a;
    followed.step(shell.model, shell.pinned_at_one_side(), kTick, nullptr, a);
    fresh.step(shell.model, shell.pinned_at_one_side(), kTick, nullptr, b);
    EXPECT_TRUE(a.x == b.x && a.v == b.v) << shell.cuts.size();
  };
  for (int i = 0; i < 4; ++i) {
    shell.cuts.make_one();
    followed.follow(shell.model);
    expect_equal_steps();
  }
  for (int i = 0; i < 3; ++i) {
    shell.cuts.undo_one();
    followed.follow(shell.model);
    expect_equal_steps();
  }
}

}  // namespace
}  // namespace kerf::fem
