// Errors name fields as kerf.v1 does, so that whoever reads one finds the field in the request.
#include <functional>
#include <limits>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include "kerf/v1/scene.pb.h"
#include "server/core/fem/element/material.h"
#include "server/core/sheet/sheet.h"
#include "server/service/wire/scene_codec.h"
#include "tests/wire/bad_scenes.h"
#include "tests/wire/scene_samples.h"

namespace kerf::wire {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

// True if "loads[2].edge.region.line.a.x" is a field of the message, or, at its end, one of its choices ("mesh").
bool exists(const Descriptor* message, const std::string& path) {
  std::istringstream names(std::regex_replace(path, std::regex(R"(\[\d+\])"), ""));
  std::string name;
  while (std::getline(names, name, '.')) {
    if (message == nullptr) return false;
    const FieldDescriptor* const field = message->FindFieldByName(name);
    if (field == nullptr) return message->FindOneofByName(name) != nullptr && names.eof();
    message = field->type() == FieldDescriptor::TYPE_MESSAGE ? field->message_type() : nullptr;
  }
  return true;
}

void expect_named(const Error& error) {
  EXPECT_TRUE(exists(v1::Scene::descriptor(), error.field)) << error.reason << " " << error.field;
  EXPECT_NE(error.message.find(error.field), std::string::npos) << error.field << " is not in: " << error.message;
}

TEST(FieldNames, ThePathsOfThisTestAreTold) {
  EXPECT_TRUE(exists(v1::Scene::descriptor(), "loads[2].edge.region.line.a.x"));
  EXPECT_TRUE(exists(v1::Scene::descriptor(), "mesh"));
  EXPECT_FALSE(exists(v1::Scene::descriptor(), "material.youngs_modulus_1_pa"));
  EXPECT_FALSE(exists(v1::Scene::descriptor(), "mesh.grid"));
  EXPECT_FALSE(exists(v1::Scene::descriptor(), "tick_rate_hz.x"));
}

TEST(FieldNames, OfScenesThatAreRefusedAreThoseOfTheProto) {
  for (const testing::BadScene& bad : testing::bad_scenes()) {
    v1::Scene scene = testing::full_scene();
    bad.spoil(scene);
    const Result<scene::SheetConfig> config = decode_scene(scene);
    ASSERT_FALSE(config.ok()) << bad.field;
    EXPECT_TRUE(exists(v1::Scene::descriptor(), config.error().field)) << config.error().field;
  }
}

TEST(FieldNames, OfMaterialsAreThoseOfTheProto) {
  for (double fem::Material::*const member :
       {&fem::Material::youngs_modulus_1, &fem::Material::youngs_modulus_2, &fem::Material::shear_modulus,
        &fem::Material::poissons_ratio_12, &fem::Material::direction, &fem::Material::thickness,
        &fem::Material::density, &fem::Material::bending_scale, &fem::Material::mass_damping,
        &fem::Material::stiffness_damping, &fem::Material::strain_limit}) {
    fem::Material material;
    material.*member = std::numeric_limits<double>::quiet_NaN();
    expect_named(fem::validate(material, "materials[3].material").error());
  }
  for (std::optional<double> fem::Material::*const member :
       {&fem::Material::bending_stiffness_1, &fem::Material::bending_stiffness_2, &fem::Material::bending_coupling,
        &fem::Material::twisting_stiffness}) {
    fem::Material material;
    material.*member = std::numeric_limits<double>::quiet_NaN();
    expect_named(fem::validate(material, "materials[3].material").error());
  }
  fem::Material material;
  material.youngs_modulus_2 = 100.0 * material.youngs_modulus_1;
  const Error error = fem::validate(material).error();
  EXPECT_EQ(error.reason, "MATERIAL_NOT_POSITIVE_DEFINITE");
  EXPECT_EQ(error.field, "material.poissons_ratio");
  EXPECT_NE(error.message.find("youngs_modulus_2_pa"), std::string::npos) << error.message;
}

// A sheet that Sheet::create refuses, once its scene was found to be one.
Error refusal(const std::function<void(scene::SheetConfig&)>& spoil) {
  scene::SheetConfig config;
  config.mesh = scene::GridSource{4, 4, 1.0, 1.0, scene::GridPattern::kUniformDiagonals, 0};
  spoil(config);
  const Result<sheet::Sheet> sheet = sheet::Sheet::create(config);
  return sheet.ok() ? Error{} : sheet.error();
}

TEST(FieldNames, OfSheetsThatCannotBeMadeAreThoseOfTheProto) {
  const scene::MaterialBox nowhere{{2.0, 2.0}, {3.0, 3.0}};
  const Error stiff = refusal([](scene::SheetConfig& c) {
    c.mesh = scene::GridSource{4, 4, 1e-5, 1e-5, scene::GridPattern::kUniformDiagonals, 0};
    c.material = fem::isotropic(1.0e12, 0.3, 1.0e-3, 0.01);
    c.tick_rate_hz = 1.0;
  });
  EXPECT_EQ(stiff.reason, "SHEET_TOO_STIFF");
  EXPECT_EQ(stiff.field, "material.youngs_modulus_pa");
  EXPECT_TRUE(exists(v1::Scene::descriptor(), stiff.field));
  for (const Error& error : {refusal([&](scene::SheetConfig& c) { c.pins = {nowhere}; }),
                             refusal([&](scene::SheetConfig& c) { c.constraints.emplace_back().region = nowhere; }),
                             refusal([&](scene::SheetConfig& c) {
                               c.materials = {{nowhere, c.material}};
                             }),
                             refusal([&](scene::SheetConfig& c) {
                               c.materials = {{scene::RegionEdge::kTop, c.material}};
                             }),
                             refusal([&](scene::SheetConfig& c) {
                               c.loads = {{scene::EdgeForce{nowhere, {1.0, 0.0, 0.0}, true}, {}}};
                             }),
                             refusal([&](scene::SheetConfig& c) {
                               c.loads = {{scene::EdgeMoment{nowhere, 1.0, true}, {}}};
                             }),
                             refusal([&](scene::SheetConfig& c) {
                               c.loads = {{scene::AreaForce{nowhere, {1.0, 0.0, 0.0}, true}, {}}};
                             }),
                             refusal([&](scene::SheetConfig& c) {
                               c.loads = {{scene::Pressure{nowhere, 1.0}, {}}};
                             }),
                             refusal([](scene::SheetConfig& c) {
                               c.loads = {{scene::PointForce{Eigen::Vector2d(2.0, 2.0), {1.0, 0.0, 0.0}}, {}}};
                             }),
                             refusal([](scene::SheetConfig& c) {
                               c.loads = {{scene::PointForce{mesh::VertexId{99}, {1.0, 0.0, 0.0}}, {}}};
                             }),
                             refusal([](scene::SheetConfig& c) { c.pins = {std::vector<mesh::VertexId>{99}}; }),
                             refusal([](scene::SheetConfig& c) {
                               c.planar = true;
                               c.placement.y_axis = Eigen::Vector3d(0.0, 1.0, 1.0).normalized();
                             })}) {
    ASSERT_FALSE(error.field.empty()) << error.reason;
    expect_named(error);
  }
}

}  // namespace
}  // namespace kerf::wire
