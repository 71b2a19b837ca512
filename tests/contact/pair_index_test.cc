#include "server/core/contact/pair_index.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contact/random_pairs.h"

namespace kerf::contact {
namespace {

TEST(PairIndex, FindsPairsWithOneOfTheVertices) {
  SeededRandom random(7);
  PairIndex index;
  for (const int count : kCounts) {
    const RandomPairs of(FeaturePair::Kind::kEdgeEdge, count, random);
    index.set(of.pairs.vertices, of.pairs.size(), of.motion.slack.size());
    for (const int num_vertices : {0, 1, 5}) {
      std::vector<mesh::VertexId> vertices;
      for (int k = 0; k < num_vertices; ++k) vertices.push_back(static_cast<mesh::VertexId>(random.below(60)));
      std::vector<std::int32_t> expected;
      for (std::size_t p = 0; p < of.pairs.size(); ++p) {
        const auto ids = of.ids(p);
        if (std::any_of(vertices.begin(), vertices.end(), [&](mesh::VertexId v) {
              return std::find(ids.begin(), ids.end(), static_cast<std::size_t>(v)) != ids.end();
            })) {
          expected.push_back(static_cast<std::int32_t>(p));
        }
      }
      std::vector<std::int32_t> found{3, 4};
      index.find(vertices, found);
      EXPECT_EQ(found, expected) << count << ", " << num_vertices;
    }
  }
}

}  // namespace
}  // namespace kerf::contact
