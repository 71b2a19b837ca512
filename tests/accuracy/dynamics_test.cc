// Motion that has a closed form: free fall, momentum and angular momentum of a spinning sheet.
#include <cmath>

#include <Eigen/Geometry>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/accuracy/reference.h"

namespace kerf::accuracy {
namespace {

struct Scheme {
  std::string name;
  fem::IntegratorKind kind;
  double allowed_spin_loss;  // -, of angular momentum, a second
};
void PrintTo(const Scheme& scheme, std::ostream* out) {
  *out << scheme.name;
}

class FreeFall : public testing::TestWithParam<Scheme> {};

TEST_P(FreeFall, FollowsTheBallisticPathAndKeepsItsMomenta) {
  const Reference reference("09a_free_fall_momentum");
  constexpr double kTick = 1e-3;  // s
  const double side = reference.geometry("a");
  const mesh::TriangleMesh mesh = mesh::make_grid({.num_x = 7, .num_y = 7, .width = side, .height = side}).value();
  const fem::Model model(mesh, reference.material());
  fem::State state;
  state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  state.v = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  const Eigen::Vector3d omega(0.0, 0.0, 5.0);
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    state.x.col(i).head<2>() = mesh.rest_position(i) - Eigen::Vector2d(0.5 * side, 0.5 * side);
    state.v.col(i) = Eigen::Vector3d(1.0, 0.0, 2.0) + omega.cross(state.x.col(i));
  }
  const Eigen::Vector3d start = model.centre_of_mass(state.x);
  const auto spin = [&] {
    const fem::Momentum momentum = model.momentum(state);
    return Eigen::Vector3d(momentum.angular - model.centre_of_mass(state.x).cross(momentum.linear));
  };
  const Eigen::Vector3d spin_before = spin();
  const Eigen::Vector3d momentum_before = model.momentum(state).linear;
  EXPECT_NEAR(spin_before.z(), reference.value("angular momentum about the centre of mass L_z (constant)"),
              0.1 * spin_before.z());

  fem::IntegratorOptions options;
  options.kind = GetParam().kind;
  options.linear_solver = linear::LinearSolverKind::kDirect;
  const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
  integrator->rebuild(model);
  const fem::Loads loads;
  const double late = GetParam().kind == fem::IntegratorKind::kImplicitEuler ? kTick : 0.0;
  const std::vector<std::vector<double>> momenta = reference.rows("linear momentum");
  std::size_t next = 1;  // row 0 is the start
  int tick = 0;
  for (const std::vector<double>& row : reference.rows("centre of mass")) {
    for (; tick < std::lround(row[0] / kTick); ++tick) integrator->step(model, loads, kTick, nullptr, state);
    const Eigen::Vector3d centre = model.centre_of_mass(state.x) - start;
    EXPECT_NEAR(centre.x(), row[1], 1e-9) << row[0];
    EXPECT_NEAR(centre.z(), row[2] - 0.5 * 9.81 * row[0] * late, 1e-9) << row[0];
    ASSERT_EQ(momenta.at(next)[0], row[0]);
    const Eigen::Vector3d expected(momenta[next][1], momenta[next][2], momenta[next][3]);
    EXPECT_LT((model.momentum(state).linear - expected).norm(), 1e-9 * momentum_before.norm()) << row[0];
    ++next;
  }
  const double loss = (spin() - spin_before).norm() / spin_before.norm();
  std::printf("%s: angular momentum changed by %.2e in 1 s of ticks of 1 ms\n", GetParam().name.c_str(), loss);
  EXPECT_LE(loss, GetParam().allowed_spin_loss);
}

INSTANTIATE_TEST_SUITE_P(Schemes, FreeFall,
                         testing::Values(Scheme{"Explicit", fem::IntegratorKind::kExplicit, 1e-9},
                                         Scheme{"TrBdf2", fem::IntegratorKind::kTrBdf2, 1e-3},
                                         Scheme{"ImplicitEuler", fem::IntegratorKind::kImplicitEuler, 0.05}),
                         [](const testing::TestParamInfo<Scheme>& tested) { return tested.param.name; });

}  // namespace
}  // namespace kerf::accuracy
