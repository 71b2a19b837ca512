#include "server/core/sheet/vertex_ancestry.h"

#include <vector>

#include <gtest/gtest.h>

namespace kerf::sheet {
namespace {

// Cuts of a mesh of 10 vertices. The first copies vertex 3 as 10 and makes 11 on an edge; the second copies 10 as 12
// and 11 as 13.
std::vector<DoneCut> two_cuts() {
  std::vector<DoneCut> cuts(2);
  cuts[0].edit.undo.num_vertices = 10;
  cuts[0].edit.edit.added_vertices = {{10, {3, 3, 3}, {1.0, 0.0, 0.0}}, {11, {3, 4, 4}, {0.5, 0.25, 0.25}}};
  cuts[1].edit.undo.num_vertices = 12;
  cuts[1].edit.edit.added_vertices = {{12, {10, 10, 10}, {1.0, 0.0, 0.0}}, {13, {11, 11, 11}, {1.0, 0.0, 0.0}}};
  return cuts;
}

TEST(VertexAncestry, LeavesOldVerticesAlone) {
  const VertexAncestry ancestry(two_cuts());
  EXPECT_FALSE(ancestry.is_new(9));
  EXPECT_EQ(ancestry.ancestor(9), 9);
}

TEST(VertexAncestry, TracesCopiesOfCopies) {
  const VertexAncestry ancestry(two_cuts());
  EXPECT_TRUE(ancestry.is_new(10));
  EXPECT_EQ(ancestry.ancestor(10), 3);
  EXPECT_EQ(ancestry.ancestor(12), 3);
}

TEST(VertexAncestry, HasNoneForPointsThatTheCutsMade) {
  const VertexAncestry ancestry(two_cuts());
  EXPECT_EQ(ancestry.ancestor(11), mesh::kNone);
  EXPECT_EQ(ancestry.ancestor(13), mesh::kNone);
}

}  // namespace
}  // namespace kerf::sheet
