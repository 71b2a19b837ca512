#include "tests/support/self_contact_scenes.h"

#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <variant>

#include <gtest/gtest.h>

#include "server/core/contact/intersections.h"
#include "server/core/fem/element/state.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/sheet.h"
#include "tests/support/solid_triangles.h"

namespace kerf::sheet {
namespace {

using scenes::SelfContactScene;

Sheet make(scene::SheetConfig config) {
  Result<Sheet> made = Sheet::create(std::move(config));
  EXPECT_TRUE(made.ok()) << made.error().message;
  return std::move(made).value();
}

std::int64_t pairs(const Sheet& sheet) {
  return contact::IntersectionSearch().count(test::solid_triangles(sheet.mesh()), sheet.state().x);
}

// -, largest |l / l0 - 1| of an edge
double largest_stretch(const Sheet& sheet) {
  double largest = 0.0;
  for (const auto& corners : test::solid_triangles(sheet.mesh())) {
    for (int k = 0; k < 3; ++k) {
      const mesh::VertexId a = corners[k], b = corners[(k + 1) % 3];
      const double rest = (sheet.mesh().rest_position(a) - sheet.mesh().rest_position(b)).norm();
      largest = std::max(largest, std::abs((sheet.state().x.col(a) - sheet.state().x.col(b)).norm() / rest - 1.0));
    }
  }
  return largest;
}

TEST(SelfContactScenes, StartWithoutIntersectionsAtAnySize) {
  std::set<char> letters;
  for (const SelfContactScene& scene : scenes::self_contact_scenes()) {
    SCOPED_TRACE(scene.name);
    EXPECT_TRUE(letters.insert(scene.letter).second);
    EXPECT_EQ(pairs(make(scene.make())), 0);
    Sheet small = make(scene.make_small());
    EXPECT_EQ(pairs(small), 0);
    EXPECT_LT(small.mesh().num_vertices(), 400);
    for (int i = 0; i < 3; ++i) {
      const TickReport report = small.step({});
      EXPECT_FALSE(report.frozen);
      for (const ScheduledReply& done : report.scheduled) EXPECT_TRUE(done.reply.ok());
    }
  }
}

TEST(SelfContactScenes, AStandsOnItsEdge) {
  const Sheet sheet = make(scenes::falls_on_edge());
  EXPECT_EQ(sheet.mesh().num_vertices(), 2500);
  EXPECT_NEAR(sheet.state().x.row(2).minCoeff(), 0.01, 1e-12);
  EXPECT_NEAR(sheet.state().x.row(2).maxCoeff(), 1.01, 1e-12);
  EXPECT_LT(largest_stretch(sheet), 0.012);
}

TEST(SelfContactScenes, TheLayersOfCAreThreeThicknessesApart) {
  for (const int side : {12, 50}) {
    const Sheet sheet = make(scenes::folded_twice(side));
    EXPECT_LT(largest_stretch(sheet), 0.03);
    std::set<long> layers;  // heights in thicknesses, of vertices away from the folds
    for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
      if (v % side == side / 2 || v / side == side / 2) continue;
      const double height = sheet.state().x(2, v) / sheet.config().material.thickness - 0.5;
      EXPECT_NEAR(height, std::round(height), 1e-9);
      layers.insert(std::lround(height));
    }
    EXPECT_EQ(layers, (std::set<long>{3, 6, 9, 12}));
  }
}

TEST(SelfContactScenes, TheLipsOfDCoincide) {
  const int side = 50;
  const Sheet sheet = make(scenes::falls_in_strips(side));
  EXPECT_EQ(sheet.mesh().num_pieces(), 5);
  EXPECT_EQ(sheet.mesh().num_vertices(), side * (side + 4));
  std::set<std::array<double, 3>> places;
  for (Eigen::Index v = 0; v < sheet.state().x.cols(); ++v) {
    places.insert({sheet.state().x(0, v), sheet.state().x(1, v), sheet.state().x(2, v)});
  }
  EXPECT_EQ(places.size(), static_cast<std::size_t>(side * side));
}

TEST(SelfContactScenes, TheEndsOfETurnByFourTurns) {
  Sheet sheet = make(scenes::twisted_strip(26));
  const double width = 0.04;
  // Corners of both ends, at the lower edge of the strip.
  const mesh::VertexId left = 0, right = 25;
  double turns = 0.0;
  double before = 0.0;
  const auto angle = [&](mesh::VertexId v) { return std::atan2(sheet.state().x(2, v), -sheet.state().x(1, v)); };
  for (int i = 0; i < 240; ++i) {
    ASSERT_FALSE(sheet.step({}).frozen);
    const double now = angle(right) - angle(left);
    turns += std::remainder(now - before, 2.0 * std::acos(-1.0)) / (2.0 * std::acos(-1.0));
    before = now;
  }
  EXPECT_NEAR(std::abs(turns), 4.0, 1e-6);
  EXPECT_NEAR((sheet.state().x.col(right) - sheet.state().x.col(left)).x(), 0.75, 1e-9);
  EXPECT_NEAR(sheet.state().x.col(left).tail<2>().norm(), 0.5 * width, 1e-9);
}

TEST(SelfContactScenes, TheUpperLayerOfFComesAtTenMetresASecond) {
  Sheet sheet = make(scenes::thrown_on_a_layer(12));
  ASSERT_EQ(sheet.mesh().num_pieces(), 2);
  EXPECT_NEAR(sheet.pieces()[1].world_centroid.z() - sheet.pieces()[0].world_centroid.z(), 0.05, 1e-9);
  const Eigen::Index half = sheet.state().x.cols() / 2;
  // A tick is longer than the way down, so the rate of ticks is changed to see the moment before.
  scene::SheetConfig config = scenes::thrown_on_a_layer(12);
  config.tick_rate_hz = 1000.0;
  sheet = make(std::move(config));
  sheet.step({});
  EXPECT_LT(sheet.state().v.leftCols(half).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_NEAR(sheet.state().v.rightCols(half).row(2).maxCoeff(), -10.0 - 9.81e-3, 1e-3);
}

TEST(SelfContactScenes, RHasFiftyCuts) {
  Sheet sheet = make(scenes::falls_after_cuts(20));
  const TickReport report = sheet.step({});
  ASSERT_EQ(report.scheduled.size(), 50U);
  for (const ScheduledReply& done : report.scheduled) {
    ASSERT_TRUE(done.reply.ok());
    EXPECT_EQ(done.reply->cut->status, cut::CutStatus::kApplied);
  }
}

}  // namespace
}  // namespace kerf::sheet
