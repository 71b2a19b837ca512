// Puts bad values (see bad_values.h) into every number of a scene and of a command. They must be refused with the
// field, or the sheet must stay finite.
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/fem/element/state.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/sheet/sheet.h"
#include "tests/stability/bad_values.h"
#include "tests/support/scenes.h"

namespace kerf::stability {
namespace {

using scene::Command;
using scene::SheetConfig;
using sheet::Sheet;

// Returns a scene that uses every feature: two materials, measured bending stiffness, pins, a moving constraint, every
// kind of load and of collider.
SheetConfig full_scene() {
  SheetConfig config = scenes::hanging(6);
  config.material.mass_damping = 0.1;
  config.material.stiffness_damping = 1e-4;
  config.materials.push_back({scene::MaterialBox{{-0.1, -0.1}, {1.1, 0.5}}, fem::isotropic(1e6, 0.3, 1e-3, 300.0)});
  fem::Material& given = config.materials[0].material;
  given.bending_stiffness_1 = 1.0e-4;
  given.bending_stiffness_2 = 8.0e-5;
  given.bending_coupling = 2.0e-5;
  given.twisting_stiffness = 3.0e-5;
  config.wind = {{1.0, 0.5, 0.0}, 1.2, 1.0};
  config.colliders = {{contact::Plane{{0.0, 0.0, -2.0}, {0.0, 0.0, 1.0}}, 0.5},
                      {contact::Sphere{{0.5, 0.4, 0.3}, 0.2}, 0.5},
                      {contact::OrientedBox{{0.2, -0.5, 0.2}, {0.1, 0.1, 0.1}, {0.0, 1.0, 0.0}, 0.3}, 0.5},
                      {contact::Capsule{{0.0, 0.101, 0.0}, {1.0, 0.101, 0.0}, 0.1}, 0.5}};
  scene::Constraint& constraint = config.constraints.emplace_back();
  constraint.region = scene::NearestVertex{{0.0, 0.0}};
  constraint.displacement = {0.0, 0.01, 0.0};
  constraint.rotation = scene::Rotation{{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, 0.1};
  constraint.history = {{0.0, 1.0}, {0.0, 1.0}};
  constraint.until = 10.0;
  const scene::History always{{0.0}, {1.0}};
  scene::EdgeForce outward{scene::RegionEdge::kRight};
  outward.normal = 0.01;
  outward.factor = scene::LinearFactor{{0.0, 0.5}, {0.5, 2.0}};
  config.loads = {{scene::PointForce{mesh::VertexId{3}, {0.0, 0.01, 0.0}}, always},
                  {scene::EdgeForce{scene::RegionEdge::kBottom, {0.0, 0.01, 0.0}, true}, always},
                  {scene::AreaForce{scene::WholeSheet{}, {0.0, 0.01, 0.0}, true}, always},
                  {scene::Pressure{scene::WholeSheet{}, 1.0}, always},
                  {scene::EdgeMoment{scene::RegionEdge::kBottom, 1e-5, true}, always},
                  {outward, always}};
  config.gravity_history = always;
  config.initial_velocity = scene::InitialVelocity{{0.1, 0.0, 0.0}, {0.0, 0.1, 0.0}, Eigen::Vector3d(0.5, 0.0, 0.5)};
  return config;
}

struct Field {
  const char* name;
  std::function<double&(SheetConfig& config)> at;
};

template <typename Shape>
Shape& shape(SheetConfig& config, std::size_t i) {
  return std::get<Shape>(config.colliders[i].shape);
}
template <typename Load>
Load& load(SheetConfig& config, std::size_t i) {
  return std::get<Load>(config.loads[i].kind);
}

std::vector<Field> material_fields() {
  return {
      {"young 1", [](SheetConfig& c) -> double& { return c.material.youngs_modulus_1; }},
      {"young 2", [](SheetConfig& c) -> double& { return c.materials[0].material.youngs_modulus_2; }},
      {"poisson", [](SheetConfig& c) -> double& { return c.material.poissons_ratio_12; }},
      {"shear", [](SheetConfig& c) -> double& { return c.materials[0].material.shear_modulus; }},
      {"direction", [](SheetConfig& c) -> double& { return c.material.direction; }},
      {"thickness", [](SheetConfig& c) -> double& { return c.materials[0].material.thickness; }},
      {"density", [](SheetConfig& c) -> double& { return c.material.density; }},
      {"density of a region", [](SheetConfig& c) -> double& { return c.materials[0].material.density; }},
      {"bending scale", [](SheetConfig& c) -> double& { return c.material.bending_scale; }},
      {"D11", [](SheetConfig& c) -> double& { return *c.materials[0].material.bending_stiffness_1; }},
      {"D22", [](SheetConfig& c) -> double& { return *c.materials[0].material.bending_stiffness_2; }},
      {"D12", [](SheetConfig& c) -> double& { return *c.materials[0].material.bending_coupling; }},
      {"D66", [](SheetConfig& c) -> double& { return *c.materials[0].material.twisting_stiffness; }},
      {"mass damping", [](SheetConfig& c) -> double& { return c.material.mass_damping; }},
      {"stiffness damping", [](SheetConfig& c) -> double& { return c.materials[0].material.stiffness_damping; }},
      {"region of a material",
       [](SheetConfig& c) -> double& { return std::get<scene::MaterialBox>(c.materials[0].region.shape).max.x(); }},
  };
}

std::vector<Field> contact_fields() {
  return {
      {"plane point", [](SheetConfig& c) -> double& { return shape<contact::Plane>(c, 0).point.z(); }},
      {"plane normal", [](SheetConfig& c) -> double& { return shape<contact::Plane>(c, 0).normal.x(); }},
      {"sphere centre", [](SheetConfig& c) -> double& { return shape<contact::Sphere>(c, 1).centre.y(); }},
      {"sphere radius", [](SheetConfig& c) -> double& { return shape<contact::Sphere>(c, 1).radius; }},
      {"box centre", [](SheetConfig& c) -> double& { return shape<contact::OrientedBox>(c, 2).centre.x(); }},
      {"box extents", [](SheetConfig& c) -> double& { return shape<contact::OrientedBox>(c, 2).half_extents.z(); }},
      {"box axis", [](SheetConfig& c) -> double& { return shape<contact::OrientedBox>(c, 2).axis.y(); }},
      {"box angle", [](SheetConfig& c) -> double& { return shape<contact::OrientedBox>(c, 2).angle; }},
      {"capsule end", [](SheetConfig& c) -> double& { return shape<contact::Capsule>(c, 3).b.x(); }},
      {"capsule radius", [](SheetConfig& c) -> double& { return shape<contact::Capsule>(c, 3).radius; }},
      {"friction of a plane", [](SheetConfig& c) -> double& { return c.colliders[0].friction; }},
      {"friction of a capsule", [](SheetConfig& c) -> double& { return c.colliders[3].friction; }},
  };
}

std::vector<Field> load_fields() {
  return {
      {"gravity", [](SheetConfig& c) -> double& { return c.gravity.y(); }},
      {"gravity factor", [](SheetConfig& c) -> double& { return c.gravity_history.factors[0]; }},
      {"gravity time", [](SheetConfig& c) -> double& { return c.gravity_history.times[0]; }},
      {"wind velocity", [](SheetConfig& c) -> double& { return c.wind.velocity.z(); }},
      {"air density", [](SheetConfig& c) -> double& { return c.wind.air_density; }},
      {"drag", [](SheetConfig& c) -> double& { return c.wind.drag_coefficient; }},
      {"displacement", [](SheetConfig& c) -> double& { return c.constraints[0].displacement.x(); }},
      {"stretch", [](SheetConfig& c) -> double& { return c.constraints[0].stretch(1, 0); }},
      {"rotation axis", [](SheetConfig& c) -> double& { return c.constraints[0].rotation->axis.z(); }},
      {"rotation centre", [](SheetConfig& c) -> double& { return c.constraints[0].rotation->centre.x(); }},
      {"rotation angle", [](SheetConfig& c) -> double& { return c.constraints[0].rotation->angle; }},
      {"constraint time", [](SheetConfig& c) -> double& { return c.constraints[0].history.times[1]; }},
      {"constraint factor", [](SheetConfig& c) -> double& { return c.constraints[0].history.factors[1]; }},
      {"constraint end", [](SheetConfig& c) -> double& { return *c.constraints[0].until; }},
      {"point force", [](SheetConfig& c) -> double& { return load<scene::PointForce>(c, 0).force.x(); }},
      {"edge force", [](SheetConfig& c) -> double& { return load<scene::EdgeForce>(c, 1).force.y(); }},
      {"area force", [](SheetConfig& c) -> double& { return load<scene::AreaForce>(c, 2).force.z(); }},
      {"pressure", [](SheetConfig& c) -> double& { return load<scene::Pressure>(c, 3).pressure; }},
      {"edge moment", [](SheetConfig& c) -> double& { return load<scene::EdgeMoment>(c, 4).moment; }},
      {"normal force", [](SheetConfig& c) -> double& { return *load<scene::EdgeForce>(c, 5).normal; }},
      {"zero of a factor", [](SheetConfig& c) -> double& { return load<scene::EdgeForce>(c, 5).factor->zero.x(); }},
      {"slope by x", [](SheetConfig& c) -> double& { return load<scene::EdgeForce>(c, 5).factor->slope.x(); }},
      {"slope by y", [](SheetConfig& c) -> double& { return load<scene::EdgeForce>(c, 5).factor->slope.y(); }},
      {"load factor", [](SheetConfig& c) -> double& { return c.loads[3].history.factors[0]; }},
      {"initial velocity", [](SheetConfig& c) -> double& { return c.initial_velocity->linear.x(); }},
      {"initial spin", [](SheetConfig& c) -> double& { return c.initial_velocity->angular.z(); }},
      {"centre of spin", [](SheetConfig& c) -> double& { return c.initial_velocity->centre->y(); }},
  };
}

std::vector<Field> other_fields() {
  return {
      {"width", [](SheetConfig& c) -> double& { return std::get<scene::GridSource>(c.mesh).width; }},
      {"origin", [](SheetConfig& c) -> double& { return c.placement.origin.x(); }},
      {"axis", [](SheetConfig& c) -> double& { return c.placement.x_axis.y(); }},
      {"tick rate", [](SheetConfig& c) -> double& { return c.tick_rate_hz; }},
      {"solver tolerance", [](SheetConfig& c) -> double& { return c.integrator.solver_tolerance; }},
      {"highest mode damping", [](SheetConfig& c) -> double& { return c.integrator.highest_mode_damping; }},
      {"covariance root", [](SheetConfig& c) -> double& { return c.integrator.covariance_root.power; }},
  };
}

bool are_equal(const linear::VertexField& a, const linear::VertexField& b) {
  return a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

// Expects finite states, and that a failed step leaves the sheet unchanged.
void expect_finite_steps(Sheet& sheet) {
  for (int tick = 0; tick < 3; ++tick) {
    const fem::State before = sheet.state();
    const sheet::TickReport report = sheet.step({});
    EXPECT_TRUE(fem::is_finite(sheet.state()));
    if (!report.step_failed) continue;
    EXPECT_TRUE(are_equal(sheet.state().x, before.x) && are_equal(sheet.state().v, before.v));
  }
}

TEST(StabilityOfScenes, OneBadValueInAnyField) {
  Result<Sheet> good = Sheet::create(full_scene());
  ASSERT_TRUE(good.ok()) << good.error().field << ": " << good.error().message;
  expect_finite_steps(*good);
  EXPECT_GT(good->contact_phases(), 0);
  int num_refused = 0;
  for (const std::vector<Field>& fields : {material_fields(), contact_fields(), load_fields(), other_fields()}) {
    for (const Field& field : fields) {
      for (const double bad : kBadValues) {
        SCOPED_TRACE(std::string(field.name) + " " + std::to_string(bad));
        SheetConfig config = full_scene();
        field.at(config) = bad;
        Result<Sheet> made = Sheet::create(std::move(config));
        if (made.ok()) {
          EXPECT_TRUE(std::isfinite(bad));
          expect_finite_steps(*made);
          continue;
        }
        ++num_refused;
        EXPECT_EQ(made.error().code, ErrorCode::kInvalidArgument);
        EXPECT_FALSE(made.error().field.empty());
        EXPECT_FALSE(made.error().message.empty());
      }
    }
  }
  EXPECT_GT(num_refused, 300);
}

struct BadCommand {
  const char* name;
  std::function<Command(double bad)> make;
};

std::vector<BadCommand> bad_commands() {
  const auto cut = [](auto change) {
    return [change](double bad) -> Command {
      scene::Cut made = scenes::line_cut({0.2, 0.31}, {0.8, 0.33});
      change(made, bad);
      return made;
    };
  };
  return {
      {"grab point",
       [](double bad) -> Command {
         return scene::Grab{"b", Eigen::Vector2d(bad, 0.5), std::nullopt, 0.0};
       }},
      {"grab target",
       [](double bad) -> Command {
         return scene::Grab{"b", mesh::VertexId{1}, Eigen::Vector3d(0.0, bad, 0.0), 0.0};
       }},
      {"grab stiffness",
       [](double bad) -> Command {
         return scene::Grab{"b", mesh::VertexId{1}, std::nullopt, bad};
       }},
      {"drag",
       [](double bad) -> Command {
         return scene::Drag{"a", {0.0, 0.0, bad}};
       }},
      {"pins",
       [](double bad) -> Command {
         return scene::SetPins{{scene::MaterialBox{{0.0, 0.0}, {bad, 1.0}}}};
       }},
      {"gravity",
       [](double bad) -> Command {
         return scene::SetGravity{{bad, 0.0, 0.0}};
       }},
      {"wind velocity",
       [](double bad) -> Command {
         return scene::SetWind{{{0.0, bad, 0.0}, 1.2, 1.0}};
       }},
      {"air density",
       [](double bad) -> Command {
         return scene::SetWind{{{0.0, 1.0, 0.0}, bad, 1.0}};
       }},
      {"drag coefficient",
       [](double bad) -> Command {
         return scene::SetWind{{{0.0, 1.0, 0.0}, 1.2, bad}};
       }},
      {"line",
       [](double bad) -> Command {
         return scenes::line_cut({0.2, 0.3}, {bad, 0.3});
       }},
      {"Bezier",
       [](double bad) -> Command {
         return scenes::bezier_cut({0.2, 0.5}, {0.4, bad}, {0.6, 0.2}, {0.8, 0.5});
       }},
      {"circle",
       [](double bad) -> Command {
         return scenes::circle_cut({bad, 0.5}, 0.1);
       }},
      {"radius",
       [](double bad) -> Command {
         return scenes::circle_cut({0.5, 0.5}, bad);
       }},
      {"tolerance", cut([](scene::Cut& c, double bad) { c.options.tolerance = bad; })},
      {"tolerance in metres", cut([](scene::Cut& c, double bad) { c.options.tolerance_m = bad; })},
      {"angle", cut([](scene::Cut& c, double bad) { c.options.min_angle_deg = bad; })},
      {"edge length at tips", cut([](scene::Cut& c, double bad) { c.options.tip_edge_length_m = bad; })},
      {"grading", cut([](scene::Cut& c, double bad) { c.options.tip_grading = bad; })},
      {"width", cut([](scene::Cut& c, double bad) { c.options.width_m = bad; })},
  };
}

TEST(StabilityOfCommands, OneBadValueInAnyField) {
  const Result<Sheet> good = Sheet::create(full_scene());
  ASSERT_TRUE(good.ok());
  int num_refused = 0;
  for (const BadCommand& command : bad_commands()) {
    for (const double bad : kBadValues) {
      SCOPED_TRACE(std::string(command.name) + " " + std::to_string(bad));
      Sheet sheet = *good;
      const std::vector<Command> grab{scene::Grab{"a", mesh::VertexId{8}, std::nullopt, 0.0}};
      ASSERT_TRUE(sheet.step(grab).replies[0].ok());
      const std::uint64_t hash = sheet.state_hash();
      const std::vector<Command> given{command.make(bad)};
      const sheet::TickReport report = sheet.apply(given);
      if (!report.replies[0].ok()) {
        ++num_refused;
        EXPECT_EQ(report.replies[0].error().code, ErrorCode::kInvalidArgument);
        EXPECT_FALSE(report.replies[0].error().message.empty());
        EXPECT_EQ(sheet.state_hash(), hash);
      } else {
        EXPECT_TRUE(std::isfinite(bad));
      }
      expect_finite_steps(sheet);
    }
  }
  EXPECT_GT(num_refused, 80);
}

}  // namespace
}  // namespace kerf::stability
