#include "server/core/sheet/grab_set.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sheet/moving_parts.h"

namespace kerf::sheet {
namespace {

using testing::ElementsAre;

constexpr double kDt = 1.0 / 60.0;  // s

class GrabSetTest : public testing::Test {
 protected:
  Status add(const scene::Grab& grab) { return grabs_.add(grab, sheet_.mesh(), sheet_.model(), sheet_.state().x, kDt); }
  static scene::Grab at_vertex(const std::string& id, mesh::VertexId vertex) { return {id, vertex, {}, 0.0}; }

  MovingSheet sheet_ = moving_sheet_of(scenes::flat(5));  // cells of 0.25 m
  GrabSet grabs_;
};

TEST_F(GrabSetTest, RefusesAnIdTwiceAndUnknownOnes) {
  ASSERT_TRUE(add(at_vertex("hand", 6)).ok());
  EXPECT_EQ(add(at_vertex("hand", 7)).error().reason, "GRAB_EXISTS");
  EXPECT_EQ(grabs_.drag({"other", {}}).error().reason, "GRAB_NOT_FOUND");
  EXPECT_EQ(grabs_.release({"other"}).error().field, "release.grab_id");
  EXPECT_TRUE(grabs_.release({"hand"}).ok());
  EXPECT_TRUE(grabs_.empty());
}

TEST_F(GrabSetTest, RefusesPointsWithoutMaterialAndOneGrabTooMany) {
  EXPECT_EQ(add(at_vertex("a", 25)).error().reason, "UNKNOWN_VERTEX");
  EXPECT_EQ(add({"a", Eigen::Vector2d(1.5, 0.5), {}, 0.0}).error().reason, "POINT_OUTSIDE");
  for (std::size_t i = 0; i < scene::kMaxGrabs; ++i) ASSERT_TRUE(add(at_vertex(std::to_string(i), 6)).ok());
  EXPECT_EQ(add(at_vertex("more", 6)).error().reason, "TOO_MANY_GRABS");
}

TEST_F(GrabSetTest, MovesTargetsEvenlyDuringAStep) {
  ASSERT_TRUE(add(at_vertex("hand", 6)).ok());
  const Eigen::Vector3d begin = sheet_.state().x.col(6);
  ASSERT_TRUE(grabs_.drag({"hand", begin + Eigen::Vector3d(0.0, 0.0, 0.1)}).ok());
  const auto speed = [&] {
    std::vector<fem::Grab> loads;
    grabs_.set(sheet_.stepper().integrator(), sheet_.model(), kDt, loads);
    return loads.at(0).velocity.z();
  };
  EXPECT_DOUBLE_EQ(speed(), 0.1 / kDt);
  grabs_.end_step();
  EXPECT_EQ(speed(), 0.0) << "the target has arrived";
}

TEST_F(GrabSetTest, KeepsFixedVerticesSorted) {
  ASSERT_TRUE(add(at_vertex("a", 12)).ok());
  ASSERT_TRUE(add({"point", Eigen::Vector2d(0.3, 0.4), {}, 0.0}).ok());
  ASSERT_TRUE(add(at_vertex("b", 3)).ok());
  std::vector<mesh::VertexId> vertices{1, 20};
  grabs_.add_vertices_to(vertices);
  EXPECT_THAT(vertices, ElementsAre(1, 3, 12, 20)) << "a grab of a point fixes no vertex";
}

TEST_F(GrabSetTest, LeavesVerticesThatAnUndoTakesAway) {
  ASSERT_TRUE(add(at_vertex("copy", 6)).ok());
  ASSERT_TRUE(add(at_vertex("made", 7)).ok());
  ASSERT_TRUE(add(at_vertex("old", 2)).ok());
  std::vector<DoneCut> cuts(1);  // as if vertices from 5 on were new, and 6 a copy of 1
  cuts[0].edit.undo.num_vertices = 5;
  cuts[0].edit.edit.added_vertices = {{6, {1, 1, 1}, {1.0, 0.0, 0.0}}};
  grabs_.leave_new_vertices(VertexAncestry(cuts), sheet_.mesh());
  EXPECT_EQ(grabs_.all()[0].vertices[0], 1);
  EXPECT_FALSE(grabs_.all()[0].material);
  EXPECT_EQ(grabs_.all()[1].material, sheet_.mesh().rest_position(7));
  EXPECT_EQ(grabs_.all()[2].vertices[0], 2);
}

}  // namespace
}  // namespace kerf::sheet
