// The family tree of a sheet's pieces.
#include <numeric>

#include "server/core/scene/lineage.h"
#include "server/core/scene/sheet_materials.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

double surface_density(const Sheet& sheet) {
  return sheet.config().material.density * sheet.config().material.thickness;
}

TEST(Lineage, ASheetBeginsWithOnePieceThatHasNoParent) {
  const Sheet sheet = make(scenes::hanging(9));
  const std::vector<scene::Piece> pieces = sheet.pieces();
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].birth.id, 1);
  EXPECT_EQ(pieces[0].birth.parent, 0);
  EXPECT_EQ(pieces[0].birth.cut, 0);
  EXPECT_EQ(pieces[0].label, 0);
  EXPECT_EQ(pieces[0].num_triangles, 128);
  EXPECT_NEAR(pieces[0].area, 1.0, 1e-12);
  EXPECT_NEAR(pieces[0].mass, surface_density(sheet), 1e-12);
  EXPECT_LT((pieces[0].centroid - Eigen::Vector2d(0.5, 0.5)).norm(), 1e-12);
  EXPECT_LT((pieces[0].world_centroid - Eigen::Vector3d(0.5, 0.0, 0.5)).norm(), 1e-12);
}

TEST(Lineage, APieceThatFallsApartEndsAndItsPartsAreItsChildren) {
  Sheet sheet = make(scenes::hanging(11));
  const Result<scene::CommandReply> slit = apply(sheet, scenes::line_cut({0.3, 0.45}, {0.7, 0.45}));
  ASSERT_TRUE(slit.ok());
  EXPECT_TRUE(slit->cut->split_pieces.empty()) << "a slit divides nothing";

  const Result<scene::CommandReply> halves = apply(sheet, scenes::line_cut({-0.1, 0.25}, {1.1, 0.25}));
  ASSERT_TRUE(halves.ok());
  ASSERT_EQ(halves->cut->split_pieces.size(), 1U);
  const scene::SplitPiece& split = halves->cut->split_pieces[0];
  EXPECT_EQ(split.id, 1);
  ASSERT_EQ(split.children.size(), 2U);
  std::vector<double> areas;
  for (const scene::Piece& child : split.children) {
    EXPECT_EQ(child.birth.parent, 1);
    EXPECT_EQ(child.birth.cut, 2);
    areas.push_back(child.area);
    EXPECT_NEAR(child.mass, surface_density(sheet) * child.area, 1e-15);
    const double y = child.area < 0.5 ? 0.125 : 0.625;
    EXPECT_LT((child.centroid - Eigen::Vector2d(0.5, y)).norm(), 1e-9);
    EXPECT_LT((child.world_centroid - Eigen::Vector3d(0.5, 0.0, y)).norm(), 1e-9);
  }
  EXPECT_EQ(split.children[0].birth.id, 2);
  EXPECT_EQ(split.children[1].birth.id, 3);
  EXPECT_NEAR(std::min(areas[0], areas[1]), 0.25, 1e-9);
  EXPECT_NEAR(areas[0] + areas[1], 1.0, 1e-12);

  // One cut through the three pieces of another: each falls apart on its own.
  const Result<scene::CommandReply> down = apply(sheet, scenes::line_cut({0.1, -0.1}, {0.1, 1.1}));
  ASSERT_TRUE(down.ok());
  ASSERT_EQ(down->cut->split_pieces.size(), 2U);
  EXPECT_EQ(down->cut->split_pieces[0].id, 2);
  EXPECT_EQ(down->cut->split_pieces[1].id, 3);
  const std::vector<scene::Piece> pieces = sheet.pieces();
  ASSERT_EQ(pieces.size(), 4U);
  for (const scene::Piece& piece : pieces) {
    EXPECT_GE(piece.birth.id, 4);
    EXPECT_EQ(piece.birth.cut, 3);
    EXPECT_EQ(sheet.mesh().num_pieces(), 4);
  }
}

TEST(Lineage, OfABatchHasEveryGeneration) {
  Sheet sheet = make(scenes::hanging(11));
  const Result<scene::CommandReply> reply =
      apply(sheet, scene::CutBatch{{scenes::line_cut({-0.1, 0.25}, {1.1, 0.25}), scenes::circle_cut({0.5, 0.6}, 0.2),
                                    scenes::line_cut({0.5, 0.3}, {0.5, 0.95})}});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  const scene::SplitPiece& first = reply->batch[0].split_pieces.at(0);
  ASSERT_EQ(first.children.size(), 2U);
  EXPECT_NEAR(first.children[0].area + first.children[1].area, 1.0, 1e-12);
  const scene::SplitPiece& second = reply->batch[1].split_pieces.at(0);
  const scene::Piece& divided = second.id == first.children[0].birth.id ? first.children[0] : first.children[1];
  EXPECT_EQ(divided.birth.id, second.id);
  EXPECT_EQ(divided.label, mesh::kNone) << "it is no more when the batch is done";
  EXPECT_NEAR(divided.area, 0.75, 1e-9);
  EXPECT_LT((divided.centroid - Eigen::Vector2d(0.5, 0.625)).norm(), 1e-9);
  const scene::SplitPiece& third = reply->batch[2].split_pieces.at(0);
  EXPECT_EQ(third.children.size(), 2U) << "the disc is halved, the rest of the line is a slit on either side";
  EXPECT_EQ(sheet.pieces().size(), 4U);
}

TEST(Lineage, UndoEndsIdsAndRedoGivesThemBack) {
  Sheet sheet = make(scenes::hanging(11));
  ASSERT_TRUE(apply(sheet, scenes::line_cut({-0.1, 0.25}, {1.1, 0.25})).ok());
  const std::vector<std::int64_t> halves = piece_ids(sheet);
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(piece_ids(sheet), std::vector<std::int64_t>{1});
  ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_EQ(piece_ids(sheet), halves);
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  const Result<scene::CommandReply> other = apply(sheet, scenes::line_cut({0.5, -0.1}, {0.5, 1.1}));
  ASSERT_TRUE(other.ok());
  EXPECT_EQ(other->cut->number, 2) << "a number is not given twice";
  for (const std::int64_t id : piece_ids(sheet)) EXPECT_GT(id, 3) << "nor is an id";
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_EQ(piece_ids(sheet), std::vector<std::int64_t>{1});
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.5, -0.1}, {0.5, 1.1})).ok());
  for (const std::int64_t id : piece_ids(sheet)) EXPECT_GT(id, 5);
}

}  // namespace
}  // namespace kerf::sheet
