#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"
#include "tests/support/meshes.h"

namespace kerf::contact {

// Cells of a lattice in the material plane, some of them left out, with lips along a part of one column.
struct LatticeSheet {
  int columns = 1, rows = 1;              // cells
  double edge = 1.0;                      // m, of a cell
  int slit = 0;                           // column of lattice points with two vertices; 0: none
  int slit_begin = 0, slit_end = 0;       // rows of these points
  std::function<bool(int, int)> is_hole;  // of a cell (column, row)

  [[nodiscard]] mesh::TriangleMesh mesh() const {
    mesh::IndexedMesh sheet;
    const auto num_points = static_cast<std::size_t>((columns + 1) * (rows + 1));
    std::vector<int> id(2 * num_points, -1);
    std::vector<Eigen::Vector2d> rest;
    std::vector<Eigen::Vector3i> triangles;
    const auto vertex = [&](int i, int j, bool is_right) {
      const bool is_copy = is_right && slit > 0 && i == slit && j >= slit_begin && j < slit_end;
      int& known = id[static_cast<std::size_t>(j * (columns + 1) + i) + (is_copy ? num_points : 0)];
      if (known < 0) {
        known = static_cast<int>(rest.size());
        rest.emplace_back(edge * i, edge * j);
      }
      return known;
    };
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        if (is_hole && is_hole(i, j)) continue;
        const bool is_right = i >= slit;
        const int a = vertex(i, j, is_right), b = vertex(i + 1, j, is_right);
        const int c = vertex(i + 1, j + 1, is_right), d = vertex(i, j + 1, is_right);
        triangles.emplace_back(a, b, c);
        triangles.emplace_back(a, c, d);
      }
    }
    sheet.rest = Eigen::Map<const Eigen::Matrix2Xd>(rest.front().data(), 2, static_cast<Eigen::Index>(rest.size()));
    sheet.triangles =
        Eigen::Map<const Eigen::Matrix3Xi>(triangles.front().data(), 3, static_cast<Eigen::Index>(triangles.size()));
    return test::must(mesh::import_mesh(sheet));
  }
};

// Returns the vertices of a mesh at place(material position, piece), m.
template <typename Place>
linear::VertexField placed(const mesh::TriangleMesh& mesh, const Place& place) {
  linear::VertexField x(mesh.num_vertices());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    x.col(v) = place(mesh.rest_position(v), mesh.piece(mesh.triangle_at(v)));
  }
  return x;
}

// Sheets with borders, lips and holes in different places.
inline mesh::TriangleMesh with_slit() {
  return LatticeSheet{.columns = 10, .rows = 10, .edge = 0.1, .slit = 5, .slit_begin = 3, .slit_end = 8, .is_hole = {}}
      .mesh();
}
inline mesh::TriangleMesh in_two_pieces() {
  return LatticeSheet{.columns = 10, .rows = 10, .edge = 0.1, .slit = 6, .slit_begin = 0, .slit_end = 11, .is_hole = {}}
      .mesh();
}
// Two arms, one cell apart, and a hole below them.
inline mesh::TriangleMesh with_arms_and_a_hole() {
  const auto is_hole = [](int i, int j) { return (i == 4 && j >= 4) || (i >= 3 && i <= 5 && j == 2); };
  return LatticeSheet{
      .columns = 9, .rows = 10, .edge = 0.1, .slit = 0, .slit_begin = 0, .slit_end = 0, .is_hole = is_hole}
      .mesh();
}

}  // namespace kerf::contact
