#pragma once

// Checks any committed edit from the mesh before, the mesh after and the record alone.

#include <algorithm>

#include <gtest/gtest.h>

#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"
#include "tests/support/vertex_sources.h"

namespace kerf::test {

// Checks the mesh's invariants, and that new ids are consecutive and weights give back rest positions. The rewritten
// slots, copied into the mesh before, must give the mesh after.
inline void expect_sound(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after,
                         const mesh::MeshEdit& edit) {
  ASSERT_EQ(after.find_violation(), std::nullopt);
  ASSERT_EQ(static_cast<std::int32_t>(edit.added_vertices.size()), after.num_vertices() - before.num_vertices());
  for (std::size_t i = 0; i < edit.added_vertices.size(); ++i) {
    ASSERT_EQ(edit.added_vertices[i].vertex, before.num_vertices() + static_cast<std::int32_t>(i));
  }
  EXPECT_EQ(find_wrong_source(before, after, edit.added_vertices), std::nullopt);
  EXPECT_EQ(find_wrong_source(before, after, edit.moved_vertices), std::nullopt);
  const auto& rewritten = edit.rewritten_triangles;
  ASSERT_TRUE(std::is_sorted(rewritten.begin(), rewritten.end()));
  ASSERT_EQ(std::adjacent_find(rewritten.begin(), rewritten.end()), rewritten.end());
  for (mesh::TriangleId t = 0; t < after.num_triangle_slots(); ++t) {
    if (std::binary_search(rewritten.begin(), rewritten.end(), t)) continue;
    ASSERT_LT(t, before.num_triangle_slots());
    ASSERT_EQ(after.vertices(t), before.vertices(t));
    ASSERT_EQ(after.region(t), before.region(t));
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(after.neighbour(t, k), before.neighbour(t, k));
      if (after.is_solid(t)) {
        ASSERT_EQ(after.rest_position(after.vertices(t)[k]), before.rest_position(before.vertices(t)[k]));
      }
    }
  }
  for (mesh::VertexId v = 0; v < before.num_vertices(); ++v) {
    const bool is_listed = std::any_of(edit.moved_vertices.begin(), edit.moved_vertices.end(),
                                       [v](const mesh::VertexSource& source) { return source.vertex == v; });
    ASSERT_EQ(is_listed, before.rest_position(v) != after.rest_position(v)) << "vertex " << v;
  }
}

}  // namespace kerf::test
