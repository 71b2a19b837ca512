#pragma once

// Makes the zoo, small sheets that are each difficult in one way, and the grids that most tests use.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::test {

inline mesh::IndexedMesh indexed(std::initializer_list<std::array<double, 2>> rest,
                                 std::initializer_list<std::array<int, 3>> triangles) {
  mesh::IndexedMesh sheet;
  sheet.rest.resize(2, static_cast<Eigen::Index>(rest.size()));
  sheet.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  Eigen::Index i = 0;
  for (const auto& p : rest) sheet.rest.col(i++) = Eigen::Vector2d(p[0], p[1]);
  i = 0;
  for (const auto& t : triangles) sheet.triangles.col(i++) = Eigen::Vector3i(t[0], t[1], t[2]);
  return sheet;
}

// Returns the mesh of a fixture; if it could not be built, ends the test program with the reason.
inline mesh::TriangleMesh must(Result<mesh::TriangleMesh> built) {
  if (!built.ok()) {
    std::fprintf(stderr, "fixture does not build: %s\n", built.error().message.c_str());
    std::abort();
  }
  return std::move(built).value();
}

// Returns num x num vertices on the unit square; each cell is divided from lower left to upper right.
inline mesh::TriangleMesh grid(std::int32_t num) {
  return must(mesh::make_grid({num, num, 1.0, 1.0}));
}
inline mesh::TriangleMesh jittered_grid(std::int32_t num, std::uint64_t seed) {
  return must(mesh::make_jittered_grid({num, num, 1.0, 1.0}, seed));
}

// Returns num x num vertices on the unit square; the diagonals of the cells alternate.
inline mesh::TriangleMesh union_jack(std::int32_t num) {
  mesh::IndexedMesh sheet;
  sheet.rest.resize(2, num * num);
  sheet.triangles.resize(3, 2 * (num - 1) * (num - 1));
  Eigen::Index t = 0;
  for (std::int32_t j = 0; j < num; ++j) {
    for (std::int32_t i = 0; i < num; ++i) {
      const std::int32_t a = j * num + i;
      sheet.rest.col(a) = Eigen::Vector2d(i, j) / (num - 1);
      if (i + 1 == num || j + 1 == num) continue;
      const std::int32_t b = a + 1, c = a + num + 1, d = a + num;
      const bool rises = (i + j) % 2 == 0;
      sheet.triangles.col(t++) = rises ? Eigen::Vector3i(a, b, c) : Eigen::Vector3i(a, b, d);
      sheet.triangles.col(t++) = rises ? Eigen::Vector3i(a, c, d) : Eigen::Vector3i(b, c, d);
    }
  }
  return must(mesh::import_mesh(sheet));
}

// Returns the vertices joined to v by an edge, in counter-clockwise order.
inline std::vector<mesh::VertexId> one_ring(const mesh::TriangleMesh& mesh, mesh::VertexId v) {
  std::vector<mesh::TriangleId> triangles;
  mesh.triangles_around(v, triangles);
  const mesh::PointId p = mesh.point(v);
  std::vector<mesh::VertexId> ring;
  for (const mesh::TriangleId t : triangles) ring.push_back(mesh.vertices(t)[mesh::next_corner(mesh.corner_of(t, p))]);
  const mesh::TriangleId last = triangles.back();
  const int corner = mesh.corner_of(last, p);
  if (mesh.neighbour(last, mesh::next_corner(corner)) == mesh::kNone) {
    ring.push_back(mesh.vertices(last)[mesh::previous_corner(corner)]);
  }
  return ring;
}

inline mesh::IndexedMesh one_triangle() {
  return indexed({{0, 0}, {1, 0}, {0, 1}}, {{0, 1, 2}});
}

// Six triangles around vertex 0.
inline mesh::IndexedMesh fan() {
  return indexed({{0, 0}, {1, 0}, {0.5, 0.9}, {-0.5, 0.9}, {-1, 0}, {-0.5, -0.9}, {0.5, -0.9}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 1}});
}

// A square with a square hole: 8 vertices, 8 triangles, two boundary loops.
inline mesh::IndexedMesh square_with_hole() {
  return indexed({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {2, 1}, {2, 2}, {1, 2}},
                 {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}});
}

// Two squares apart: two pieces.
inline mesh::IndexedMesh two_components() {
  return indexed({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {3, 0}, {3, 1}, {2, 1}},
                 {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
}

// Two triangles that touch in one place: one point, two vertices (one for each triangle), two pieces.
inline mesh::IndexedMesh touching_corners() {
  return indexed({{0, 0}, {1, -1}, {1, 1}, {0, 0}, {-1, 1}, {-1, -1}}, {{0, 1, 2}, {3, 4, 5}});
}

// The unit square cut from the middle of its left side to its centre: vertices 1 and 2 are the two lips' ends.
inline mesh::IndexedMesh slit_square() {
  return indexed({{0.5, 0.5}, {0, 0.5}, {0, 0.5}, {0, 0}, {1, 0}, {1, 1}, {0, 1}},
                 {{0, 1, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 2}});
}

// Three sheets that meet along three cuts in one point.
inline mesh::IndexedMesh three_way_junction() {
  return indexed({{0, 0}, {2, 0}, {-1, 2}, {0, 0}, {-1, 2}, {-1, -2}, {0, 0}, {-1, -2}, {2, 0}},
                 {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}});
}

// Triangles that are almost too flat for import, beside triangles of 1 m.
inline mesh::IndexedMesh slivers() {
  return indexed({{0, 0}, {1, 0}, {0.5, 1.1e-6}, {0.5, 1}, {0.5, -1e-5}}, {{0, 2, 3}, {2, 1, 3}, {0, 1, 2}, {0, 4, 1}});
}

// A strip of 2 n triangles, n times as long as wide.
inline mesh::IndexedMesh strip(int n) {
  mesh::IndexedMesh sheet;
  sheet.rest.resize(2, 2 * (n + 1));
  sheet.triangles.resize(3, 2 * n);
  for (int i = 0; i <= n; ++i) {
    sheet.rest.col(2 * i) = Eigen::Vector2d(i, 0.0);
    sheet.rest.col(2 * i + 1) = Eigen::Vector2d(i, 1.0);
  }
  for (int i = 0; i < n; ++i) {
    sheet.triangles.col(2 * i) = Eigen::Vector3i(2 * i, 2 * i + 2, 2 * i + 3);
    sheet.triangles.col(2 * i + 1) = Eigen::Vector3i(2 * i, 2 * i + 3, 2 * i + 1);
  }
  return sheet;
}

// Four triangles of two regions around the centre of a square.
inline mesh::IndexedMesh two_regions() {
  mesh::IndexedMesh sheet =
      indexed({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}}, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
  sheet.regions = {0, 0, 7, 7};
  return sheet;
}

// Holds an opened mesh of the zoo, by name.
struct ZooMesh {
  std::string name;
  mesh::IndexedMesh sheet;
  std::int32_t pieces;
  std::int32_t loops;
};

inline std::vector<ZooMesh> zoo() {
  return {
      {"one triangle", one_triangle(), 1, 1},
      {"fan", fan(), 1, 1},
      {"square with hole", square_with_hole(), 1, 2},
      {"two components", two_components(), 2, 2},
      {"touching corners", touching_corners(), 2, 2},
      {"slit square", slit_square(), 1, 1},
      {"three-way junction", three_way_junction(), 3, 3},
      {"slivers", slivers(), 1, 1},
      {"strip", strip(20), 1, 1},
      {"two regions", two_regions(), 1, 1},
  };
}

}  // namespace kerf::test
