// Puts bad values (see bad_values.h) into every number of a step's input; scene_test.cc does the same for scenes and
// commands.
#include <cstdio>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/fem/step/integrator.h"
#include "tests/fem/fixture.h"
#include "tests/stability/bad_values.h"

namespace kerf::stability {
namespace {

// The input of a step, with every kind of load.
struct StepInput {
  explicit StepInput(const mesh::TriangleMesh& mesh, const fem::Model& model) : state(fem::rest_state(mesh)) {
    loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
    loads.wind = {{1.0, 2.0, 3.0}, 1.2, 1.2, 0.02};
    loads.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 10.0);
    loads.edge_moments = fem::border_moments(model, mesh, 1e-3);
    loads.pins.push_back({0, state.x.col(0), Eigen::Vector3d::Zero()});
    const int last = mesh.num_vertices() - 1;
    fem::Grab& grab = loads.grabs.emplace_back();
    grab.vertices[0] = last;
    grab.target = state.x.col(last);
    grab.stiffness = 10.0;
    grab.damping = 0.1;
  }

  fem::State state;
  fem::Loads loads;
};

// A kind of number in a step's input; `at` picks one of them at random.
struct Place {
  const char* name;
  std::function<double&(StepInput& input, SeededRandom& random)> at;
};

std::vector<Place> places() {
  const auto in_field = [](linear::VertexField& field, SeededRandom& random) -> double& {
    return field.data()[random.below(static_cast<std::uint64_t>(field.size()))];
  };
  const auto in_vector = [](Eigen::Vector3d& vector, SeededRandom& random) -> double& {
    return vector[static_cast<Eigen::Index>(random.below(3))];
  };
  return {
      {"x", [=](StepInput& i, SeededRandom& r) -> double& { return in_field(i.state.x, r); }},
      {"v", [=](StepInput& i, SeededRandom& r) -> double& { return in_field(i.state.v, r); }},
      {"force", [=](StepInput& i, SeededRandom& r) -> double& { return in_field(i.loads.external_forces, r); }},
      {"gravity", [=](StepInput& i, SeededRandom& r) -> double& { return in_vector(i.loads.gravity, r); }},
      {"pin target", [=](StepInput& i, SeededRandom& r) -> double& { return in_vector(i.loads.pins[0].target, r); }},
      {"pin velocity",
       [=](StepInput& i, SeededRandom& r) -> double& { return in_vector(i.loads.pins[0].velocity, r); }},
      {"grab weight", [=](StepInput& i, SeededRandom&) -> double& { return i.loads.grabs[0].weights[0]; }},
      {"grab target", [=](StepInput& i, SeededRandom& r) -> double& { return in_vector(i.loads.grabs[0].target, r); }},
      {"grab velocity",
       [=](StepInput& i, SeededRandom& r) -> double& { return in_vector(i.loads.grabs[0].velocity, r); }},
      {"grab stiffness", [](StepInput& i, SeededRandom&) -> double& { return i.loads.grabs[0].stiffness; }},
      {"grab damping", [](StepInput& i, SeededRandom&) -> double& { return i.loads.grabs[0].damping; }},
      {"wind velocity", [=](StepInput& i, SeededRandom& r) -> double& { return in_vector(i.loads.wind.velocity, r); }},
      {"air density", [](StepInput& i, SeededRandom&) -> double& { return i.loads.wind.air_density; }},
      {"normal drag", [](StepInput& i, SeededRandom&) -> double& { return i.loads.wind.normal_drag; }},
      {"tangential drag", [](StepInput& i, SeededRandom&) -> double& { return i.loads.wind.tangential_drag; }},
      {"pressure",
       [](StepInput& i, SeededRandom& r) -> double& { return i.loads.pressure[r.below(i.loads.pressure.size())]; }},
      {"edge moment",
       [](StepInput& i, SeededRandom& r) -> double& {
         return i.loads.edge_moments[r.below(i.loads.edge_moments.size())].moment;
       }},
  };
}

// A step must either refuse and leave the state unchanged, bit for bit, or end with finite numbers.
TEST(StabilityOfInput, OneBadValueAtAnyOfAThousandPlaces) {
  const mesh::TriangleMesh mesh = fem::square_grid(5);
  const fem::Model model(mesh, fem::isotropic(1e6, 0.3, 1e-3, 300.0));
  SeededRandom random(41);
  int num_refused = 0;
  int num_kept = 0;
  for (const fem::IntegratorKind kind :
       {fem::IntegratorKind::kExplicit, fem::IntegratorKind::kImplicitEuler, fem::IntegratorKind::kTrBdf2,
        fem::IntegratorKind::kTrapezoidal, fem::IntegratorKind::kBdf2, fem::IntegratorKind::kAutomatic}) {
    fem::IntegratorOptions options;
    options.kind = kind;
    const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
    integrator->rebuild(model);
    for (const Place& place : places()) {
      for (std::size_t trial = 0; trial < 4 * kBadValues.size(); ++trial) {
        StepInput input(mesh, model);
        const double bad = kBadValues[trial % kBadValues.size()];
        place.at(input, random) = bad;
        const fem::State before = input.state;
        const fem::StepStats stats = integrator->step(model, input.loads, 1.0 / 60.0, nullptr, input.state);
        SCOPED_TRACE(std::string(place.name) + " " + std::to_string(bad) + ", " +
                     std::string(integrator->explanation()));
        if ((stats.flags & fem::kFrozen) == 0U) {
          ++num_kept;
          EXPECT_TRUE(fem::is_finite(input.state));
          continue;
        }
        ++num_refused;
        const std::size_t size = sizeof(double) * static_cast<std::size_t>(before.x.size());
        EXPECT_EQ(std::memcmp(input.state.x.data(), before.x.data(), size), 0);
        EXPECT_EQ(std::memcmp(input.state.v.data(), before.v.data(), size), 0);
      }
    }
  }
  std::printf("%d refused, %d kept\n", num_refused, num_kept);
  EXPECT_GT(num_refused, 400);
  EXPECT_GT(num_kept, 400);
}

}  // namespace
}  // namespace kerf::stability
