// Cuts with a width on a sheet: what goes with the material, and what an undo brings back.
#include <algorithm>
#include <cmath>

#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Metres: hanging() is 1 m x 1 m.
scene::Cut strip(const Vector2d& from, const Vector2d& to, double width) {
  scene::Cut cut = scenes::line_cut(from, to);
  cut.options.width_m = width;
  return cut;
}

std::vector<mesh::VertexId> without_material(const mesh::TriangleMesh& mesh) {
  std::vector<mesh::VertexId> found;
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (!mesh.has_material(v)) found.push_back(v);
  }
  return found;
}

TEST(CutWidth, MassGoesAndTheRestMovesOnUnderEveryIntegrator) {
  for (const scene::IntegratorKind kind :
       {scene::IntegratorKind::kExplicitLeapfrog, scene::IntegratorKind::kImplicitEuler}) {
    scene::SheetConfig config = scenes::hanging(17);
    config.integrator.kind = kind;
    Sheet sheet = make(config);
    run(sheet, 4);
    const double mass = sheet.model().masses().total();
    const Result<scene::CommandReply> reply = apply(sheet, strip({0.2, 0.5}, {0.8, 0.45}, 0.15));
    ASSERT_TRUE(reply.ok()) << reply.error().message;
    ASSERT_TRUE(reply->cut->removed_mass.has_value());
    EXPECT_NEAR(sheet.model().masses().total() + *reply->cut->removed_mass, mass, 1e-12 * mass);
    const std::vector<mesh::VertexId> gone = without_material(sheet.mesh());
    ASSERT_GT(gone.size(), 10U);
    const Eigen::Matrix3Xd at = sheet.state().x;
    run(sheet, 30);
    EXPECT_FALSE(sheet.frozen());
    EXPECT_TRUE(sheet.state().x.allFinite());
    for (const mesh::VertexId v : gone) {
      EXPECT_EQ(sheet.state().x.col(v), at.col(v));
      EXPECT_EQ(sheet.state().v.col(v), Vector3d::Zero());
    }
  }
}

TEST(CutWidth, ViewersFindVerticesWithoutMaterialWithTheRest) {
  scene::SheetConfig config = scenes::hanging(9);
  config.pins.clear();
  Sheet sheet = make(config);
  ASSERT_TRUE(apply(sheet, strip({0.3, 0.5}, {0.7, 0.5}, 0.3)).ok());
  run(sheet, 120);  // falls for a second
  const auto snapshot = sheet.snapshot();
  const double highest = snapshot->positions.row(2).maxCoeff();
  EXPECT_LT(highest, -1.0) << "nothing stays behind where the sheet was";
  for (const auto& triangle : snapshot->topology->triangles) {
    for (const mesh::VertexId v : triangle) EXPECT_TRUE(v == mesh::kNone || sheet.mesh().has_material(v));
  }
}

TEST(CutWidth, UndoRightAwayGivesTheSheetBackWhereItWas) {
  scene::SheetConfig config = scenes::hanging(17);
  Sheet sheet = make(config);
  run(sheet, 10);
  const fem::State before = sheet.state();
  const std::uint64_t mesh = sheet.mesh().state_hash();
  const std::uint64_t model = sheet.model().hash();
  ASSERT_TRUE(apply(sheet, strip({0.2, 0.3}, {0.8, 0.6}, 0.2)).ok());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.mesh().state_hash(), mesh);
  EXPECT_EQ(sheet.model().hash(), model);
  EXPECT_TRUE(without_material(sheet.mesh()).empty());
  EXPECT_LT((sheet.state().x - before.x).colwise().norm().maxCoeff(), 2e-3) << "the shape beside is continued";
  ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_GT(without_material(sheet.mesh()).size(), 10U);
  run(sheet, 10);
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.mesh().state_hash(), mesh);
  run(sheet, 60);
  EXPECT_FALSE(sheet.frozen());
}

TEST(CutWidth, UndoPutsMaterialBackBesideItsPiece) {
  scene::SheetConfig config = scenes::hanging(13);
  config.integrator.precision = scene::Precision::kDouble;  // so that all of it has one velocity
  config.pins.clear();
  Sheet sheet = make(config);
  ASSERT_TRUE(apply(sheet, strip({0.3, 0.5}, {0.7, 0.5}, 0.25)).ok());
  run(sheet, 60);  // falls by more than a metre
  const fem::Momentum momentum = sheet.model().momentum(sheet.state());
  const Vector3d velocity = momentum.linear / sheet.model().masses().total();
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  for (Eigen::Index v = 0; v < sheet.state().x.cols(); ++v) {
    const Vector2d rest = sheet.mesh().rest_position(static_cast<mesh::VertexId>(v)) - sheet.mesh().rest_position(0);
    const Vector3d expected = sheet.state().x.col(0) + Vector3d(rest.x(), 0.0, rest.y());  // it has fallen flat
    EXPECT_LT((sheet.state().x.col(v) - expected).norm(), 1e-6) << v;
    EXPECT_LT((sheet.state().v.col(v) - velocity).norm(), 1e-6) << v;
  }
}

TEST(CutWidth, PinsGoWithTheMaterialAndComeBackWithIt) {
  Sheet sheet = make(scenes::hanging(11));
  const std::vector<mesh::VertexId> pinned = sheet.pinned_vertices();
  const double top = sheet.mesh().bounding_box().max().y();
  const double left = sheet.mesh().bounding_box().min().x();
  // Viewers ask for the pins when this has grown.
  const std::int32_t settings = sheet.settings_version();
  ASSERT_TRUE(apply(sheet, strip({left + 0.3, top - 0.5}, {left + 0.7, top - 0.5}, 0.1)).ok());
  EXPECT_EQ(sheet.settings_version(), settings) << "no pin there";
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.settings_version(), settings);
  ASSERT_TRUE(apply(sheet, strip({left - 0.1, top}, {left + 0.35, top}, 0.1)).ok());
  EXPECT_EQ(sheet.settings_version(), settings + 1);
  const std::vector<mesh::VertexId> kept = sheet.pinned_vertices();
  EXPECT_FALSE(std::includes(kept.begin(), kept.end(), pinned.begin(), pinned.end()));
  for (const mesh::VertexId v : kept) EXPECT_TRUE(sheet.mesh().has_material(v));
  run(sheet, 5);
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.pinned_vertices(), pinned);
  EXPECT_EQ(sheet.settings_version(), settings + 2);
  ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_EQ(sheet.pinned_vertices(), kept);
  ASSERT_TRUE(sheet.mesh().has_material(pinned.back()));
  ASSERT_TRUE(apply(sheet, scene::SetPins{{std::vector<mesh::VertexId>{pinned.back()}}}).ok());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.pinned_vertices(), std::vector<mesh::VertexId>{pinned.back()}) << "others were set since";
}

TEST(CutWidth, AGrabOfMaterialThatGoesHoldsTheNearestThatIsLeft) {
  Sheet sheet = make(scenes::hanging(11));
  const mesh::VertexId held = 60;  // the middle
  ASSERT_TRUE(apply(sheet, scene::Grab{"hand", held, std::nullopt, 0.0}).ok());
  ASSERT_TRUE(apply(sheet, strip({0.3, 0.5}, {0.7, 0.5}, 0.1)).ok());
  ASSERT_FALSE(sheet.mesh().has_material(held));
  ASSERT_TRUE(apply(sheet, scene::Drag{"hand", Vector3d(0.5, 0.5, 0.1)}).ok());
  run(sheet, 20);
  EXPECT_FALSE(sheet.frozen());
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"other", held, std::nullopt, 0.0})), "UNKNOWN_VERTEX");
  EXPECT_EQ(reason(apply(sheet, scene::SetPins{{std::vector<mesh::VertexId>{held}}})), "UNKNOWN_VERTEX");
  EXPECT_TRUE(apply(sheet, scene::Release{"hand"}).ok());
}

TEST(CutWidth, AWholePieceInsideTheStripEndsWithoutChildren) {
  Sheet sheet = make(scenes::hanging(17));
  const Result<scene::CommandReply> punched = apply(sheet, scenes::circle_cut({0.5, 0.5}, 0.05));
  ASSERT_TRUE(punched.ok());
  ASSERT_EQ(sheet.pieces().size(), 2U);
  const std::vector<scene::Piece> before = sheet.pieces();
  const auto disc = std::min_element(before.begin(), before.end(),
                                     [](const scene::Piece& a, const scene::Piece& b) { return a.area < b.area; });
  const Result<scene::CommandReply> reply = apply(sheet, strip({0.2, 0.5}, {0.8, 0.5}, 0.2));
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->cut->report.removed_pieces, 1);
  ASSERT_EQ(sheet.pieces().size(), 1U);
  EXPECT_NE(sheet.pieces()[0].birth.id, disc->birth.id);
  ASSERT_EQ(reply->cut->split_pieces.size(), 1U);
  EXPECT_EQ(reply->cut->split_pieces[0].id, disc->birth.id);
  EXPECT_TRUE(reply->cut->split_pieces[0].children.empty());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  ASSERT_EQ(sheet.pieces().size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(sheet.pieces()[i].birth.id, before[i].birth.id);
  ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_EQ(sheet.pieces().size(), 1U);
}

TEST(CutWidth, ABatchMayRemoveWhatItMade) {
  Sheet sheet = make(scenes::hanging(17));
  const std::int64_t first = sheet.pieces()[0].birth.id;
  const Result<scene::CommandReply> reply =
      apply(sheet, scene::CutBatch{{scenes::circle_cut({0.5, 0.5}, 0.05), strip({0.2, 0.5}, {0.8, 0.5}, 0.2)}});
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  ASSERT_EQ(reply->batch.size(), 2U);
  ASSERT_EQ(reply->batch[0].split_pieces.size(), 1U);
  EXPECT_EQ(reply->batch[0].split_pieces[0].id, first);
  ASSERT_EQ(reply->batch[0].split_pieces[0].children.size(), 2U);
  const auto& children = reply->batch[0].split_pieces[0].children;
  EXPECT_EQ(std::count_if(children.begin(), children.end(),
                          [](const scene::Piece& child) { return child.label == mesh::kNone && child.area == 0.0; }),
            1);
  for (const scene::Piece& child : children)
    EXPECT_TRUE(child.centroid.allFinite() && child.world_centroid.allFinite());
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.pieces()[0].birth.id, first);
}

TEST(CutWidth, AStripOverTheWholeSheetIsRefused) {
  Sheet sheet = make(scenes::hanging(9));
  const std::uint64_t before = sheet.state_hash();
  EXPECT_EQ(reason(apply(sheet, strip({0.0, 0.5}, {1.0, 0.5}, 3.0))), "STRIP_COVERS_SHEET");
  EXPECT_EQ(sheet.state_hash(), before);
}

}  // namespace
}  // namespace kerf::sheet
