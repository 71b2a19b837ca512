#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "server/core/fem/element/state.h"
#include "server/core/sheet/sheet.h"
#include "tests/sheet/calls.h"
#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector3d;

// The field that is refused when a good config is spoilt, or "accepted".
std::string field_of(const std::function<void(scene::SheetConfig&)>& spoil) {
  scene::SheetConfig config = scenes::hanging(4);
  spoil(config);
  const Result<Sheet> created = Sheet::create(config);
  if (created.ok()) return "accepted";
  EXPECT_EQ(created.error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(created.error().message.empty());
  return created.error().field;
}

void grid(scene::SheetConfig& config, std::int32_t columns, std::int32_t rows, double width = 1.0,
          double height = 1.0) {
  config.mesh = scene::GridSource{columns, rows, width, height, scene::GridPattern::kUniformDiagonals, 0};
  config.pins.clear();
}

TEST(SheetConfig, GridLimits) {
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { grid(c, 2, 2); }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { grid(c, 1, 5); }), "grid.columns");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { grid(c, 1001, 5); }), "grid.columns");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { grid(c, 5, -3); }), "grid.rows");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { grid(c, 1000, 501); }), "grid.rows");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { grid(c, 5, 5, 0.0); }), "grid.width_m");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { grid(c, 5, 5, 1.0, 1.1e4); }), "grid.height_m");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { grid(c, 5, 5, kNan); }), "grid.width_m");
}

TEST(SheetConfig, InlineArrays) {
  scene::ArraySource square;
  square.material_positions.resize(2, 4);
  square.material_positions << 0, 1, 1, 0,  //
      0, 0, 1, 1;
  square.triangles.resize(3, 2);
  square.triangles << 0, 0,  //
      1, 2,                  //
      2, 3;
  const auto with = [&](const std::function<void(scene::ArraySource&)>& change) {
    return field_of([&](scene::SheetConfig& c) {
      scene::ArraySource arrays = square;
      change(arrays);
      c.mesh = arrays;
      c.pins.clear();
    });
  };
  EXPECT_EQ(with([](scene::ArraySource&) {}), "accepted");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.positions = Eigen::Matrix3Xd::Zero(3, 4); }), "accepted");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.positions = Eigen::Matrix3Xd::Zero(3, 3); }), "inline.positions");
  EXPECT_EQ(with([](scene::ArraySource& a) {
              a.positions = Eigen::Matrix3Xd::Zero(3, 4);
              a.positions(1, 2) = kNan;
            }),
            "inline.positions[7]");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.material_positions.resize(2, 2); }), "inline.material_positions");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.material_positions(0, 1) = kInfinity; }), "inline.material_positions");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.triangles.resize(3, 0); }), "inline.triangles");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.triangles(0, 1) = 4; }), "inline.triangles");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.triangles(0, 1) = -1; }), "inline.triangles");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.material_positions.resize(2, 0); }), "inline.material_positions");
}

TEST(SheetConfig, InlineArraysOfACurvedSheet) {
  scene::ArraySource bent;
  bent.rest_positions.resize(3, 4);
  bent.rest_positions << 0, 1, 1, 0,  //
      0, 0, 1, 1,                     //
      0, 0, 0.3, 0;
  bent.triangles.resize(3, 2);
  bent.triangles << 0, 0,  //
      1, 2,                //
      2, 3;
  const auto with = [&](const std::function<void(scene::ArraySource&)>& change) {
    return field_of([&](scene::SheetConfig& c) {
      scene::ArraySource arrays = bent;
      change(arrays);
      c.mesh = arrays;
      c.pins.clear();
    });
  };
  EXPECT_EQ(with([](scene::ArraySource&) {}), "accepted");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.material_positions = a.rest_positions.topRows<2>(); }), "accepted");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.material_positions.resize(2, 3); }), "inline.material_positions");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.positions = Eigen::Matrix3Xd::Zero(3, 3); }), "inline.positions");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.rest_positions(0, 0) = kNan; }), "inline.rest_positions");
  EXPECT_EQ(with([](scene::ArraySource& a) { a.rest_positions.col(0) = a.rest_positions.col(1); }),
            "inline.rest_positions");
  // It starts in its rest shape, which stores nothing, or where it is put.
  scene::SheetConfig config = scenes::hanging(4);
  config.pins.clear();
  config.mesh = bent;
  const Result<Sheet> at_rest = Sheet::create(config);
  ASSERT_TRUE(at_rest.ok()) << at_rest.error().message;
  EXPECT_TRUE(at_rest->mesh().is_curved());
  EXPECT_EQ(Vector3d(at_rest->state().x.col(2)), Vector3d(1, 1, 0.3));
  bent.positions = 2.0 * bent.rest_positions;
  config.mesh = bent;
  const Result<Sheet> stretched = Sheet::create(config);
  ASSERT_TRUE(stretched.ok()) << stretched.error().message;
  EXPECT_EQ(Vector3d(stretched->state().x.col(2)), Vector3d(2, 2, 0.6));
  EXPECT_EQ(stretched->mesh(), at_rest->mesh());
}

TEST(SheetConfig, ObjPlacesTheSheetItself) {
  scene::SheetConfig config = scenes::hanging(4);
  config.pins.clear();
  config.mesh = scene::ObjSource{"v 0 0 5\nv 1 0 5\nv 0 0 6\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"};
  const Result<Sheet> created = Sheet::create(config);
  ASSERT_TRUE(created.ok()) << created.error().message;
  EXPECT_EQ(created->mesh().num_solid_triangles(), 1);
  EXPECT_EQ(Vector3d(created->state().x.col(2)), Vector3d(0, 0, 6));
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.mesh = scene::ObjSource{""}; }), "obj.text");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.mesh = scene::ObjSource{"f 1 2 3\n"}; }), "obj.text");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.mesh = scene::ObjSource{"v 0 0 nan\n"}; }), "obj.text");
}

TEST(SheetConfig, PlyPlacesTheSheetItself) {
  scene::SheetConfig config = scenes::hanging(4);
  config.pins.clear();
  config.mesh = scene::PlySource{test::write_ply(test::square_with_hole(), test::PlyKind::kLittleEndian, 5.0)};
  const Result<Sheet> created = Sheet::create(config);
  ASSERT_TRUE(created.ok()) << created.error().message;
  EXPECT_EQ(created->mesh().num_boundary_loops(), 2);
  EXPECT_EQ(Vector3d(created->state().x.col(2)), Vector3d(3, 3, 5));
  config.mesh = scene::ObjSource{test::write_obj(test::square_with_hole(), 5.0)};
  EXPECT_EQ(Sheet::create(config)->state_hash(), created->state_hash());
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.mesh = scene::PlySource{""}; }), "ply.data");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.mesh = scene::PlySource{"ply\n"}; }), "ply.data");
  const std::string three_at_an_edge =
      test::write_ply(test::indexed({{0, 0}, {1, 0}, {0, 1}, {0, -1}, {1, 1}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}),
                      test::PlyKind::kAscii);
  EXPECT_EQ(field_of([&](scene::SheetConfig& c) { c.mesh = scene::PlySource{three_at_an_edge}; }), "ply.data");
}

TEST(SheetConfig, PlacementMustBeOrthonormal) {
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.placement.x_axis = {2, 0, 0}; }), "placement.x_axis");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.placement.y_axis = {0, 0, 0}; }), "placement.y_axis");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.placement.y_axis = {1, 0, 0}; }), "placement.y_axis");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.placement.origin.y() = kNan; }), "placement.origin.y");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.placement.origin.z() = -2e6; }), "placement.origin.z");
}

TEST(SheetConfig, MaterialMustBeValid) {
  EXPECT_NE(field_of([](scene::SheetConfig& c) { c.material.youngs_modulus_1 = -1.0; }).find("material."),
            std::string::npos);
  EXPECT_NE(field_of([](scene::SheetConfig& c) { c.material.thickness = kNan; }).find("material."), std::string::npos);
}

TEST(SheetConfig, PinsNameWhatExists) {
  using Ids = std::vector<mesh::VertexId>;
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.pins = {Ids{0, 16}}; }), "pins[0].vertices.vertices[1]");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) {
              c.pins = {scene::RegionEdge::kTop, Ids{-1}};
            }),
            "pins[1].vertices.vertices[0]");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) {
              c.pins = {scene::MaterialBox{{0, kNan}, {1, 1}}};
            }),
            "pins[0].box.min.y");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.pins = {scene::MaterialBox{{0, 2}, {1, 1}}}; }), "pins[0].box.max");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.pins.resize(65, scene::RegionEdge::kTop); }), "pins");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.pins.resize(64, scene::RegionEdge::kTop); }), "accepted");
}

TEST(SheetConfig, LoadsAndColliders) {
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.gravity.x() = kNan; }), "gravity_mps2.x");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.gravity = {0, 0, 1.1e4}; }), "gravity_mps2.z");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.wind.velocity = {0, 0, -1001}; }), "wind.velocity_mps.z");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.wind.velocity = {800, 800, 0}; }), "wind.velocity_mps");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.wind.air_density = 101; }), "wind.air_density_kgpm3");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.colliders.resize(65, {contact::Plane{}, 0.0}); }), "colliders");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) {
              c.colliders = {{contact::Plane{}, 0.0}, {contact::Sphere{{0, 0, 0}, -1.0}, 0.0}};
            }),
            "colliders[1].sphere.radius_m");
}

TEST(SheetConfig, FrictionOfSelfContact) {
  for (const bool is_on : {false, true}) {
    const auto with = [=](double friction) {
      return field_of([=](scene::SheetConfig& c) { c.self_contact = {is_on, friction}; });
    };
    EXPECT_EQ(with(0.0), "accepted");
    EXPECT_EQ(with(scene::kMaxSelfFriction), "accepted");
    EXPECT_EQ(with(-1e-9), "self_contact.friction");
    EXPECT_EQ(with(10.001), "self_contact.friction");
    EXPECT_EQ(with(kNan), "self_contact.friction");
  }
}

TEST(SheetConfig, ThicknessOfSelfContact) {
  for (const bool is_on : {false, true}) {
    const auto with = [=](double thickness) {
      return field_of([=](scene::SheetConfig& c) { c.self_contact = {is_on, 0.3, thickness}; });
    };
    EXPECT_EQ(with(scene::kMinSelfThickness), "accepted");
    EXPECT_EQ(with(scene::kMaxSelfThickness), "accepted");
    EXPECT_EQ(with(0.0), "self_contact.thickness_m");
    EXPECT_EQ(with(0.999e-6), "self_contact.thickness_m");
    EXPECT_EQ(with(-1e-9), "self_contact.thickness_m");
    EXPECT_EQ(with(0.1001), "self_contact.thickness_m");
    EXPECT_EQ(with(kNan), "self_contact.thickness_m");
  }
}

TEST(SheetConfig, APlanarSheetHasNoSelfContact) {
  scene::SheetConfig config = scenes::hanging(4);
  config.self_contact.is_on = true;
  EXPECT_TRUE(Sheet::create(config).ok());
  config.planar = true;
  EXPECT_EQ(Sheet::create(config).error().reason, "SELF_CONTACT_PLANAR");
  EXPECT_EQ(Sheet::create(config).error().field, "self_contact.mode");
}

TEST(SheetConfig, TimeAndIntegrator) {
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.tick_rate_hz = 0.5; }), "tick_rate_hz");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.tick_rate_hz = 1000.0; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.tick_rate_hz = 1000.1; }), "tick_rate_hz");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.tick_rate_hz = kInfinity; }), "tick_rate_hz");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.max_substeps = 0; }), "integrator.max_substeps");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.newton_iterations = 101; }),
            "integrator.newton_iterations");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.solver_tolerance = 1e-15; }),
            "integrator.solver_tolerance");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.newton_iterations = 0; }),
            "integrator.newton_iterations");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.newton_iterations = 1; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.newton_iterations = 100; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.solver_tolerance = 1e-14; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.solver_tolerance = 0.1; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.solver_tolerance = 0.11; }),
            "integrator.solver_tolerance");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.max_linear_iterations = 0; }),
            "integrator.max_linear_iterations");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.max_linear_iterations = 1; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.max_linear_iterations = 100'000; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.max_linear_iterations = 100'001; }),
            "integrator.max_linear_iterations");
  for (const double power : {0.01, 2.0}) {
    EXPECT_EQ(field_of([=](scene::SheetConfig& c) { c.integrator.covariance_root.power = power; }), "accepted");
  }
  for (const double power : {0.0099, 2.01, -0.5, kNan}) {
    EXPECT_EQ(field_of([=](scene::SheetConfig& c) { c.integrator.covariance_root.power = power; }),
              "integrator.covariance_root.p");
  }
  for (const int iterations : {1, 50}) {
    EXPECT_EQ(
        field_of([=](scene::SheetConfig& c) { c.integrator.covariance_root.newton_schulz_iterations = iterations; }),
        "accepted");
  }
  for (const int iterations : {0, 51}) {
    EXPECT_EQ(
        field_of([=](scene::SheetConfig& c) { c.integrator.covariance_root.newton_schulz_iterations = iterations; }),
        "integrator.covariance_root.newton_schulz_iterations");
  }
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.highest_mode_damping = 0.0; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.highest_mode_damping = 0.5; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.integrator.highest_mode_damping = 0.51; }),
            "integrator.highest_mode_damping");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.ticks = -1; }), "ticks");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.ticks = 10'000'001; }), "ticks");
}

TEST(SheetConfig, NamesAndSchedule) {
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.sheet_id = "demo-1"; }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.sheet_id = "Demo"; }), "sheet_id");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.sheet_id = "1a"; }), "sheet_id");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.sheet_id = "../a"; }), "sheet_id");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.sheet_id = std::string(63, 'a'); }), "accepted");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.sheet_id = std::string(64, 'a'); }), "sheet_id");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.description = std::string(1001, 'a'); }), "description");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.commands = {{0, scene::Reset{}}}; }), "commands[0].tick");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) {
              c.commands = {{1, scene::Reset{}}, {1, scene::Drag{"", {0, 0, 0}}}};
            }),
            "commands[1].command.drag.grab_id");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) {
              c.commands = {{1, scenes::circle_cut({0, kNan}, 1)}};
            }),
            "commands[0].command.cut.curve.circle.center.y");
  EXPECT_EQ(field_of([](scene::SheetConfig& c) { c.commands.resize(10'001, {1, scene::Reset{}}); }), "commands");
}

}  // namespace
}  // namespace kerf::sheet
