// The vector code of the explicit integrator: its forces and its bits. What it does as an integrator:
// integrator_test.cc, in mixed precision: mixed_precision_test.cc.
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/leapfrog/membrane_layout.h"
#include "server/core/fem/step/explicit_integrator.h"
#include "server/core/mesh/build/mesh_import.h"
#include "tests/fem/instruction_sets.h"
#include "tests/fem/leapfrog_cases.h"

namespace kerf::fem {
namespace {

// Returns the error of one substep so short that the sheet hardly moves, v = step f / m: over the largest f / m.
double acceleration_error(const Model& model, const State& start, Precision precision, double step) {
  linear::VertexField expected(start.x.cols());
  model.internal_forces(start.x, expected);
  for (int i = 0; i < model.num_vertices(); ++i) expected.col(i) *= model.inverse_mass()[static_cast<std::size_t>(i)];
  IntegratorOptions options = options_of(precision);
  options.highest_mode_damping = 0.0;
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  State state = start;
  EXPECT_EQ(integrator->step(model, no_loads(), step, nullptr, state).substeps, 1);
  return ((state.v - start.v) / step - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

// Mixed precision steps slow sheets otherwise.
void set_moving(State& state) {
  state.v.colwise() = Eigen::Vector3d(1e-2, 0.0, -1e-2);
}

// Mixed precision computes strains of some percent from floats: a few units of 2^-24 of 1.
double tolerance_of(Precision precision) {
  return precision == Precision::kDouble ? 1e-9 : 1e-4;
}

TEST(Leapfrog, AcceleratesAsTheForcesOfTheModelSay) {
  for (const mesh::TriangleMesh& mesh : meshes()) {
    State start = crumpled_state(mesh);
    set_moving(start);
    for (const Material& material : {soft_cloth(), orthotropic_cloth()}) {
      for (const MembraneLaw law : kLaws) {
        const Model model(mesh, material, law);
        for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
          EXPECT_LT(acceleration_error(model, start, precision, 1e-9), tolerance_of(precision));
        }
      }
    }
  }
}

// Floats lose next to nothing of small strains where what is small is made from what is small.
TEST(Leapfrog, AcceleratesASheetNearlyAtRestAlmostAsInDouble) {
  constexpr double kTolerance = 32.0 * 0x1p-24;  // -
  for (const mesh::TriangleMesh& mesh : meshes()) {
    for (const Material& material : {soft_cloth(), orthotropic_cloth()}) {
      const Model model(mesh, material);
      EXPECT_LT(acceleration_error(model, quiet_state(mesh), Precision::kMixed, 1e-9), kTolerance);
    }
  }
}

mesh::TriangleMesh scaled(const mesh::TriangleMesh& mesh, double factor) {
  mesh::IndexedMesh sheet;
  sheet.rest.resize(2, mesh.num_vertices());
  for (int v = 0; v < mesh.num_vertices(); ++v) sheet.rest.col(v) = factor * mesh.rest_position(v);
  sheet.triangles.resize(3, mesh.num_solid_triangles());
  Eigen::Index t = 0;
  for (int slot = 0; slot < mesh.num_triangle_slots(); ++slot) {
    if (mesh.is_solid(slot)) sheet.triangles.col(t++) = Eigen::Map<const Eigen::Vector3i>(mesh.vertices(slot).data());
  }
  return mesh::import_mesh(sheet).value();
}

TEST(Leapfrog, AcceleratesASheetOfHalfAMicrometreAsWell) {
  constexpr double kSize = 5e-7;  // m
  const mesh::TriangleMesh mesh = scaled(square_grid(9), kSize);
  Material material = soft_cloth();
  material.bending_scale = 0.0;
  SeededRandom random(12);
  State start = rest_state(mesh);
  start.x += random_field(random, start.x.cols(), 1e-2 * kSize);
  set_moving(start);
  for (const MembraneLaw law : kLaws) {
    const Model model(mesh, material, law);
    for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
      EXPECT_LT(acceleration_error(model, start, precision, 1e-13), 10.0 * tolerance_of(precision));
    }
  }
}

TEST(Leapfrog, GivesTheSameBitsOnEveryInstructionSet) {
  std::printf("%zu instruction sets\n", hwy::SupportedAndGeneratedTargets().size());
  for (const mesh::TriangleMesh& mesh : meshes()) {
    for (const MembraneLaw law : kLaws) {
      const Model model(mesh, orthotropic_cloth(), law);
      for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
        std::vector<State> results;
        for_each_instruction_set([&] {
          const std::unique_ptr<Integrator> integrator = make_integrator(options_of(precision));
          integrator->rebuild(model);
          results.push_back(stepped(model, *integrator, crumpled_state(mesh), 2));
          results.push_back(stepped(model, *integrator, quiet_state(mesh), 1, no_loads()));
        });
        for (std::size_t i = 2; i < results.size(); ++i) EXPECT_TRUE(equal_bits(results[i], results[i % 2]));
      }
    }
  }
}

// Integrators of both precisions that follow one model from change to change.
struct Following {
  explicit Following(const Model& model) {
    for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
      integrators.push_back(make_integrator(options_of(precision)));
      integrators.back()->rebuild(model);
    }
  }
  void expect_bits_of_a_fresh_start(const mesh::TriangleMesh& mesh, const Model& model) {
    const Following fresh(model);
    for (std::size_t i = 0; i < integrators.size(); ++i) {
      integrators[i]->follow(model);
      for (const State& start : {crumpled_state(mesh), quiet_state(mesh)}) {
        EXPECT_TRUE(
            equal_bits(stepped(model, *integrators[i], start, 1), stepped(model, *fresh.integrators[i], start, 1)))
            << i;
      }
    }
  }
  std::vector<std::unique_ptr<Integrator>> integrators;
};

void expect_bits_of_a_fresh_start(MembraneLaw law) {
  for (mesh::TriangleMesh mesh : meshes()) {
    Model model(mesh, soft_cloth(), law);
    Following following(model);
    for (const double y : {0.21, 0.48, 0.74, 0.8}) {
      model.follow(mesh, slit(mesh, y));
      following.expect_bits_of_a_fresh_start(mesh, model);
    }
  }
}

TEST(Leapfrog, FollowsCutsToTheBitsOfAFreshStart) {
  for (const MembraneLaw law : kLaws) expect_bits_of_a_fresh_start(law);
}

TEST(Leapfrog, FollowsCutsTakenBackToTheBitsOfAFreshStart) {
  for (mesh::TriangleMesh mesh : meshes()) {
    Model model(mesh, soft_cloth());
    Following following(model);
    for (const double y : {0.21, 0.48, 0.74, 0.8}) {
      const mesh::TriangleMesh before = mesh;
      std::vector<mesh::TriangleId> rewritten = slit(mesh, y);
      model.follow(mesh, rewritten);
      following.expect_bits_of_a_fresh_start(mesh, model);
      std::erase_if(rewritten, [&](mesh::TriangleId slot) { return slot >= before.num_triangle_slots(); });
      model.follow(before, rewritten);
      following.expect_bits_of_a_fresh_start(before, model);
      mesh = before;
      model.follow(mesh, slit(mesh, y));
      following.expect_bits_of_a_fresh_start(mesh, model);
    }
  }
}

TEST(MembraneLayout, KeepsEachTriangleOnce) {
  for (const mesh::TriangleMesh& mesh : meshes()) {
    const Model model(mesh, soft_cloth());
    MembraneLayout layout;
    layout.rebuild(model);
    std::vector<int> times(static_cast<std::size_t>(model.num_slots()), 0);
    std::int64_t num_solid = 0;
    for (mesh::VertexId v = 0; v < model.num_vertices(); ++v) {
      for (const int kind : {0, 1}) {
        if (layout.quad_slot(kind, v) != mesh::kNone) ++times[static_cast<std::size_t>(layout.quad_slot(kind, v))];
      }
    }
    for (const mesh::TriangleId slot : layout.lanes()) {
      if (slot != mesh::kNone) ++times[static_cast<std::size_t>(slot)];
    }
    for (mesh::TriangleId slot = 0; slot < model.num_slots(); ++slot) {
      EXPECT_EQ(times[static_cast<std::size_t>(slot)], mesh.is_solid(slot) ? 1 : 0);
      num_solid += mesh.is_solid(slot) ? 1 : 0;
    }
    EXPECT_EQ(layout.num_triangles(), num_solid);
  }
}

TEST(MembraneLayout, FindsThePatternOfAGridAlone) {
  MembraneLayout layout;
  layout.rebuild(Model(square_grid(19), soft_cloth()));
  EXPECT_EQ(layout.offsets(), (QuadOffsets{1, 20, 19}));
  EXPECT_TRUE(layout.lanes().empty());
  layout.rebuild(Model(jittered_square(19), soft_cloth()));
  EXPECT_EQ(layout.offsets(), QuadOffsets{});
  mesh::TriangleMesh mesh = square_grid(19);
  slit(mesh, 0.4);
  layout.rebuild(Model(mesh, soft_cloth()));
  EXPECT_EQ(layout.offsets(), (QuadOffsets{1, 20, 19}));
  EXPECT_FALSE(layout.lanes().empty());
}

// A body that knocks a vertex out of its place in the first substep, where that is longer than `longest`, s.
class KnockingContact final : public ContactConstraint {
 public:
  explicit KnockingContact(double longest) : longest_(longest) {}
  void begin(const linear::VertexField& /*x*/) override { is_first_ = true; }
  [[nodiscard]] int num_inside() const override { return 0; }
  void enforce(double /*dt*/, State& /*state*/) override {}
  std::span<const std::int32_t> find_due_blocks(double dt, double /*travel*/) override {
    const bool knocks = is_first_ && dt > longest_;
    is_first_ = false;
    return {&kFirstBlock, knocks ? 1U : 0U};
  }
  std::uint32_t enforce_block(std::int32_t /*block*/, mesh::VertexLanes& vertices) override {
    vertices.x[2][3] += 1.0;
    ++num_knocks;
    return 1U << 3;
  }
  std::size_t find_gaps(int /*vertex*/, const Eigen::Vector3d& /*x*/, double /*reach*/,
                        std::array<SurfaceGap, kMaxGaps>& /*gaps*/) const override {
    return 0;
  }
  int num_knocks = 0;

 private:
  static constexpr std::int32_t kFirstBlock = 0;
  double longest_;
  bool is_first_ = true;
};

TEST(Leapfrog, RepeatsAStepInWhichABodyTearsTheSheetApart) {
  const mesh::TriangleMesh mesh = square_grid(30);
  const Model model(mesh, soft_cloth());
  for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
    ExplicitIntegrator integrator(options_of(precision));
    integrator.rebuild(model);
    const double planned = integrator.planned_substeps(kTick);
    KnockingContact contact(0.6 * kTick / planned);
    State state = rest_state(mesh);
    const StepStats stats = integrator.step(model, Loads(), kTick, &contact, state);
    // The vertex leaves the room of fixed-point positions, and the step is first made again in double.
    const bool is_mixed = precision == Precision::kMixed;
    EXPECT_EQ(contact.num_knocks, is_mixed ? 2 : 1);
    EXPECT_EQ(stats.flags, kSubstepped | (is_mixed ? kWidened : 0U));
    EXPECT_GE(stats.substeps, 2 * planned);
    EXPECT_LT(stats.max_strain, 0.1);
  }
}

}  // namespace
}  // namespace kerf::fem
