#include <gtest/gtest.h>

#include "server/base/random.h"
#include "tests/sheet/calls.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

TEST(Snapshot, SharesTheTopologyUntilItChanges) {
  Sheet sheet = make(scenes::hanging(10));
  const auto first = sheet.snapshot();
  sheet.step({});
  const auto second = sheet.snapshot();
  EXPECT_EQ(first->topology, second->topology);
  EXPECT_EQ(second->tick, 1);
  EXPECT_NE(first->positions, second->positions);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.3, 0.5}, {0.7, 0.5})).ok());
  const auto third = sheet.snapshot();
  EXPECT_NE(second->topology, third->topology);
  EXPECT_EQ(third->topology->version, 2);
  EXPECT_EQ(third->positions.cols(), sheet.mesh().num_vertices());
  EXPECT_EQ(third->topology->material_positions.cols(), sheet.mesh().num_vertices());
}

// Copy of a viewer, updated slot by slot from versions alone.
struct Mirror {
  std::int32_t version = 0;
  std::vector<std::array<mesh::VertexId, 3>> triangles;
  std::vector<std::int32_t> pieces;
  Eigen::Matrix2Xd material;

  void follow(const Topology& topology) {
    const bool full = version < topology.patchable_since;
    triangles.resize(topology.triangles.size(), {-9, -9, -9});
    pieces.resize(topology.pieces.size(), -9);
    material.conservativeResize(2, topology.material_positions.cols());
    for (std::size_t s = 0; s < triangles.size(); ++s) {
      if (!full && topology.slot_versions[s] <= version) continue;
      triangles[s] = topology.triangles[s];
      pieces[s] = topology.pieces[s];
    }
    for (Eigen::Index v = 0; v < material.cols(); ++v) {
      if (!full && topology.vertex_versions[static_cast<std::size_t>(v)] <= version) continue;
      material.col(v) = topology.material_positions.col(v);
    }
    version = topology.version;
  }
};

TEST(Snapshot, PatchesByVersionLeadToTheSameTopologyFromAnyVersion) {
  Sheet sheet = make(scenes::hanging(10));
  std::vector<Mirror> mirrors;
  SeededRandom random(17);
  for (int round = 0; round < 14; ++round) {
    Mirror joined;
    joined.follow(*sheet.snapshot()->topology);
    mirrors.push_back(joined);
    if (round == 8) {
      ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
      continue;
    }
    const double x0 = random.uniform(-0.2, 1.2);
    const double y0 = random.uniform(-0.2, 1.2);
    const double x1 = random.uniform(-0.2, 1.2);
    ASSERT_TRUE(apply(sheet, scenes::line_cut({x0, y0}, {x1, random.uniform(-0.2, 1.2)})).ok());
  }
  const std::shared_ptr<const Snapshot> last = sheet.snapshot();
  EXPECT_GT(last->topology->version, 10);
  for (Mirror& mirror : mirrors) {
    mirror.follow(*last->topology);
    EXPECT_EQ(mirror.triangles, last->topology->triangles);
    EXPECT_EQ(mirror.pieces, last->topology->pieces);
    EXPECT_TRUE(mirror.material == last->topology->material_positions);
  }
}

TEST(Snapshot, CutsThatNobodyLookedAtAreInTheNextPatch) {
  Sheet sheet = make(scenes::hanging(12));
  Mirror mirror;
  mirror.follow(*sheet.snapshot()->topology);
  for (const scene::Cut& cut : scenes::three_cuts()) ASSERT_TRUE(apply(sheet, cut).ok());
  const auto topology = sheet.snapshot()->topology;
  EXPECT_EQ(topology->version, 4);
  EXPECT_EQ(topology->patchable_since, 1);
  mirror.follow(*topology);
  EXPECT_EQ(mirror.triangles, topology->triangles);
  EXPECT_EQ(mirror.pieces, topology->pieces);
  EXPECT_EQ(mirror.material, topology->material_positions);
  // After an undo that was not viewed either, a patch would not suffice.
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  ASSERT_TRUE(apply(sheet, scenes::circle_cut({0.7, 0.3}, 0.1)).ok());
  const auto after = sheet.snapshot()->topology;
  EXPECT_EQ(after->patchable_since, after->version);
  mirror.follow(*after);
  EXPECT_EQ(mirror.triangles, after->triangles);
  EXPECT_EQ(mirror.material, after->material_positions);
}

TEST(Snapshot, ASheetRewrittenMoreThanOnceUnseenIsSentWhole) {
  Sheet sheet = make(scenes::hanging(4));
  const std::int32_t seen = sheet.snapshot()->topology->version;
  for (int i = 0; i < 12; ++i) ASSERT_TRUE(apply(sheet, scenes::circle_cut({0.5, 0.5}, 0.05 + 0.03 * i)).ok());
  const auto topology = sheet.snapshot()->topology;
  EXPECT_GT(topology->patchable_since, seen);
  EXPECT_EQ(topology->triangles.size(), static_cast<std::size_t>(sheet.mesh().num_triangle_slots()));
}

}  // namespace
}  // namespace kerf::sheet
