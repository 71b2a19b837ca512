#include "server/core/mesh/build/grid_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "server/base/check.h"
#include "server/base/random.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/refine/delaunay.h"

namespace kerf::mesh {
namespace {

Status check_config(const GridConfig& config) {
  const auto num_vertices = static_cast<std::int64_t>(config.num_x) * config.num_y;
  if (config.num_x < 2 || config.num_y < 2 || num_vertices > kMaxVertices) {
    return invalid_argument("GRID_SIZE",
                            "a grid has at least 2 x 2 and at most " + std::to_string(kMaxVertices) +
                                " vertices, not " + std::to_string(config.num_x) + " x " + std::to_string(config.num_y),
                            "grid");
  }
  for (const double side : {config.width, config.height}) {
    if (!(side >= 1e-6 && side <= kMaxRestCoordinate)) {  // catches NaN too
      return invalid_argument("GRID_EXTENT", "the sides of a grid are 1e-6 to 1e4 m, not " + std::to_string(side),
                              "grid");
    }
  }
  return Nothing{};
}

Eigen::Matrix2Xd grid_positions(const GridConfig& config) {
  Eigen::Matrix2Xd rest(2, config.num_x * config.num_y);
  for (std::int32_t j = 0; j < config.num_y; ++j) {
    for (std::int32_t i = 0; i < config.num_x; ++i) {
      rest(0, j * config.num_x + i) = i * config.width / (config.num_x - 1);
      rest(1, j * config.num_x + i) = j * config.height / (config.num_y - 1);
    }
  }
  return rest;
}

// Returns the Delaunay triangles of the given positions inside the rectangle; the border edges of the grid are kept.
// Each triangle begins with its lowest vertex, and triangles are in lexicographic order.
std::vector<std::array<VertexId, 3>> triangulate_rectangle(const GridConfig& config, const Eigen::Matrix2Xd& rest) {
  const Lattice lattice =
      Lattice::for_bounds(Eigen::AlignedBox2d(Eigen::Vector2d::Zero(), Eigen::Vector2d(config.width, config.height)));
  std::vector<LatticePoint> points;
  for (Eigen::Index v = 0; v < rest.cols(); ++v) points.push_back(lattice.nearest(rest.col(v)));
  TriangleMesh domain = make_empty_domain(lattice);
  MeshEditor editor(domain);
  const std::vector<PointId> inserted = insert_delaunay(editor, points);
  std::vector<VertexId> vertex(points.size() + 4, kNone);
  for (std::size_t v = 0; v < points.size(); ++v) vertex[inserted[v]] = static_cast<VertexId>(v);

  std::vector<VertexId> border;
  const std::int32_t nx = config.num_x, ny = config.num_y;
  border.reserve(2 * (static_cast<std::size_t>(nx) + static_cast<std::size_t>(ny)));
  for (std::int32_t i = 0; i < nx - 1; ++i) border.push_back(i);
  for (std::int32_t j = 0; j < ny - 1; ++j) border.push_back(j * nx + nx - 1);
  for (std::int32_t i = nx - 1; i > 0; --i) border.push_back((ny - 1) * nx + i);
  for (std::int32_t j = ny - 1; j > 0; --j) border.push_back(j * nx);
  for (std::size_t i = 0; i < border.size(); ++i) {
    const VertexId from = border[i], to = border[(i + 1) % border.size()];
    const Recovery made = editor.recover_edge(inserted[from], inserted[to], kLockOriginal);
    KERF_CHECK(made.status == Recovery::Status::kRecovered, "nothing lies on or crosses the border of a grid");
  }

  std::vector<std::array<VertexId, 3>> triangles;
  for (TriangleId t = 0; t < domain.num_triangle_slots(); ++t) {
    std::array<VertexId, 3> corners{};
    for (int k = 0; k < 3; ++k) corners[k] = vertex[domain.points(t)[k]];
    // A rectangle is convex, so every triangle outside it has a corner of the domain (kNone).
    if (std::min({corners[0], corners[1], corners[2]}) == kNone) continue;
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace

Result<TriangleMesh> make_grid(const GridConfig& config) {
  KERF_TRY(check_config(config));
  IndexedMesh sheet;
  sheet.rest = grid_positions(config);
  sheet.triangles.resize(3, 2 * (config.num_x - 1) * (config.num_y - 1));
  std::int32_t t = 0;
  for (std::int32_t j = 0; j + 1 < config.num_y; ++j) {
    for (std::int32_t i = 0; i + 1 < config.num_x; ++i) {
      const std::int32_t v = j * config.num_x + i;
      const std::int32_t above = v + config.num_x;
      sheet.triangles.col(t++) = Eigen::Vector3i(v, v + 1, above + 1);
      sheet.triangles.col(t++) = Eigen::Vector3i(v, above + 1, above);
    }
  }
  return import_mesh(sheet);
}

Result<TriangleMesh> make_jittered_grid(const GridConfig& config, std::uint64_t seed) {
  KERF_TRY(check_config(config));
  IndexedMesh sheet;
  sheet.rest = grid_positions(config);
  const Eigen::Vector2d cell(config.width / (config.num_x - 1), config.height / (config.num_y - 1));
  SeededRandom random(seed);
  for (std::int32_t j = 1; j + 1 < config.num_y; ++j) {
    for (std::int32_t i = 1; i + 1 < config.num_x; ++i) {
      sheet.rest(0, j * config.num_x + i) += cell.x() * random.uniform(-0.3, 0.3);
      sheet.rest(1, j * config.num_x + i) += cell.y() * random.uniform(-0.3, 0.3);
    }
  }
  const std::vector<std::array<VertexId, 3>> triangles = triangulate_rectangle(config, sheet.rest);
  sheet.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    sheet.triangles.col(static_cast<Eigen::Index>(t)) =
        Eigen::Vector3i(triangles[t][0], triangles[t][1], triangles[t][2]);
  }
  return import_mesh(sheet);
}

}  // namespace kerf::mesh
