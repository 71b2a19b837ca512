#include "server/core/sheet/mesh_cuts.h"

#include <vector>

#include <gtest/gtest.h>

#include "server/base/state_hash.h"
#include "server/core/fem/model/transfer.h"
#include "server/core/sheet/cut_log.h"
#include "tests/sheet/moving_parts.h"

namespace kerf::sheet {
namespace {

class MeshCutsTest : public testing::Test {
 protected:
  Result<MeshCuts> cut(const std::vector<scene::Cut>& cuts, std::int32_t max_vertices = scene::kMaxVertices) {
    const CutSurroundings around{max_vertices, sheet_.pins(), sheet_.grabs(), sheet_.state().x,
                                 sheet_.materials().by_region()};
    return cut_mesh(cuts, cuts.size() > 1, around, mesh_, nullptr);
  }
  [[nodiscard]] std::uint64_t mesh_hash() const {
    StateHash hash;
    mesh_.add_to(hash);
    return hash.value();
  }

  MovingSheet sheet_ = moving_sheet_of(scenes::hanging(9));
  mesh::TriangleMesh mesh_ = sheet_.mesh();
};

TEST_F(MeshCutsTest, RefusedCutOfABatchLeavesTheMeshAsItWas) {
  const std::uint64_t before = mesh_hash();
  const Result<MeshCuts> refused =
      cut({scenes::line_cut({0.2, 0.3}, {0.8, 0.3}), scenes::circle_cut({0.5, 0.5}, 0.1)}, 100);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "TOO_MANY_VERTICES");
  EXPECT_EQ(mesh_hash(), before);
}

TEST_F(MeshCutsTest, RepliesToCutsThatMeetNoSheetWithoutDoingThem) {
  const Result<MeshCuts> made =
      cut({scenes::line_cut({2.0, 0.3}, {3.0, 0.3}), scenes::line_cut({0.2, 0.3}, {0.8, 0.3})});
  ASSERT_TRUE(made.ok());
  ASSERT_EQ(made->replies.size(), 2U);
  EXPECT_EQ(made->replies[0].status, cut::CutStatus::kNoIntersection);
  EXPECT_EQ(made->replies[1].status, cut::CutStatus::kApplied);
  EXPECT_EQ(made->done.size(), 1U);
}

TEST_F(MeshCutsTest, LogNumbersAppliedCutsAndNamesTheirPieces) {
  Result<MeshCuts> made = cut({scenes::line_cut({2.0, 0.3}, {3.0, 0.3}), scenes::line_cut({0.2, 0.3}, {0.8, 0.3}),
                               scenes::line_cut({-0.1, 0.6}, {1.1, 0.6})});
  ASSERT_TRUE(made.ok());
  linear::VertexField x = sheet_.state().x;
  for (const DoneCut& done : made->done) fem::carry_over(done.edit.edit, x);
  CutLog log(1);
  log.add(std::move(made->done), mesh_, x, sheet_.materials().by_region(), made->replies);
  EXPECT_EQ(log.num_cuts(), 2);
  EXPECT_EQ(log.history().num_done(), 1U) << "a batch is one step";
  EXPECT_EQ(made->replies[0].number, 0);
  EXPECT_EQ(made->replies[1].number, 1);
  EXPECT_TRUE(made->replies[1].split_pieces.empty());
  EXPECT_EQ(made->replies[2].number, 2);
  EXPECT_EQ(made->replies[2].split_pieces.at(0).children.size(), 2U);
  EXPECT_EQ(log.pieces().size(), 2U);
}

TEST_F(MeshCutsTest, PinsLostAreThoseOfVerticesWithoutMaterial) {
  scene::Cut window = scenes::line_cut({-0.1, 0.95}, {1.1, 0.95});
  window.options.width_m = 0.2;
  const Result<MeshCuts> made = cut({window});
  ASSERT_TRUE(made.ok()) << made.error().message;
  ASSERT_EQ(made->done.size(), 1U);
  EXPECT_EQ(made->done[0].lost_pins.size(), sheet_.pins().vertices().size()) << "the whole upper edge is removed";
  ASSERT_TRUE(made->replies[0].removed_mass.has_value());
  EXPECT_GT(*made->replies[0].removed_mass, 0.0);
}

}  // namespace
}  // namespace kerf::sheet
