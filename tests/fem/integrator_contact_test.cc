// The contract between integrators and contact: when it is enforced, and from where steps begin again.
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/mesh/vertex_lanes.h"
#include "tests/fem/integrator_cases.h"

namespace kerf::fem {
namespace {

class IntegratorContact : public IntegratorTest {};

constexpr double kFloor = -0.05;  // m

class CountingContact final : public ContactConstraint {
 public:
  explicit CountingContact(int num_vertices) {
    for (int b = 0; b * static_cast<int>(mesh::kVertexLanes) < num_vertices; ++b) blocks.push_back(b);
  }
  void begin(const linear::VertexField& x) override { EXPECT_GE(x.row(2).minCoeff(), kFloor); }
  int num_inside() const override { return 0; }
  void enforce(double dt, State& state) override {
    count(dt);
    state.x.row(2) = state.x.row(2).cwiseMax(kFloor).eval();
  }
  std::span<const std::int32_t> find_due_blocks(double dt, double /*travel*/) override {
    count(dt);
    return blocks;
  }
  std::uint32_t enforce_block(std::int32_t /*block*/, mesh::VertexLanes& vertices) override {
    std::uint32_t moved = 0;
    for (std::size_t l = 0; l < mesh::kVertexLanes; ++l) {
      if (vertices.x[2][l] >= kFloor) continue;
      vertices.x[2][l] = kFloor;
      moved |= 1U << l;
    }
    return moved;
  }
  std::size_t find_gaps(int /*vertex*/, const Eigen::Vector3d& x, double reach,
                        std::array<SurfaceGap, kMaxGaps>& gaps) const override {
    gaps[0].gap = x.z() - kFloor;
    return gaps[0].gap < reach ? 1 : 0;
  }
  void count(double dt) {
    ++calls;
    duration += dt;
  }
  int calls = 0;
  double duration = 0.0;
  std::vector<std::int32_t> blocks;
};

TEST_P(IntegratorContact, EnforcesContactOnceASubstepAndLastOfAll) {
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  CountingContact contact(mesh.num_vertices());
  int substeps = 0;
  for (int i = 0; i < 20; ++i) {
    substeps += integrator->step(model, Loads{}, kTick, &contact, state).substeps;
    EXPECT_GE(state.x.row(2).minCoeff(), kFloor);
  }
  EXPECT_EQ(contact.calls, substeps);
  EXPECT_NEAR(contact.duration, 20 * kTick, 1e-12);
}

// Spoils the first attempt at a step.
class SpoilingContact final : public ContactConstraint {
 public:
  void begin(const linear::VertexField& x) override {
    ++attempts;
    if (attempts == 1) first = x;
    EXPECT_EQ(x, first) << "every attempt begins where the first one did";
  }
  void enforce(double /*dt*/, State& state) override {
    if (attempts == 1) state.x(0, 0) = std::numeric_limits<double>::quiet_NaN();
  }
  int num_inside() const override { return 0; }
  std::span<const std::int32_t> find_due_blocks(double /*dt*/, double /*travel*/) override { return first_block; }
  std::uint32_t enforce_block(std::int32_t /*block*/, mesh::VertexLanes& vertices) override {
    if (attempts > 1) return 0;
    vertices.v[0][0] = std::numeric_limits<double>::quiet_NaN();
    return 1;
  }
  std::size_t find_gaps(int /*vertex*/, const Eigen::Vector3d& /*x*/, double /*reach*/,
                        std::array<SurfaceGap, kMaxGaps>& /*gaps*/) const override {
    return 0;
  }
  int attempts = 0;
  linear::VertexField first;
  std::array<std::int32_t, 1> first_block{0};
};

TEST_P(IntegratorContact, ContactBeginsAgainWhenAStepDoes) {
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  SpoilingContact contact;
  const StepStats stats = integrator->step(model, Loads{}, kTick, &contact, state);
  EXPECT_EQ(contact.attempts, 2);
  const bool is_first_choice =
      integrator->kind() == IntegratorKind::kExplicit || integrator->kind() == IntegratorKind::kImplicitEuler;
  // Mixed precision that fails is made again in double, not shorter.
  const bool is_mixed =
      integrator->kind() == IntegratorKind::kExplicit && GetParam().options.precision == Precision::kMixed;
  const std::uint32_t expected = is_mixed ? kWidened : is_first_choice ? kSubstepped : kDamped;
  EXPECT_EQ(stats.flags & (kSubstepped | kDamped | kFrozen | kWidened), expected);
  EXPECT_TRUE(is_finite(state));
}

INSTANTIATE_TEST_SUITE_P(All, IntegratorContact, testing::ValuesIn(all_integrators()), case_name);
INSTANTIATE_TEST_SUITE_P(Undamped, IntegratorContact, testing::ValuesIn(undamped_integrators()), case_name);

}  // namespace
}  // namespace kerf::fem
