#include "server/core/mesh/build/first_reader.h"

#include <algorithm>
#include <array>

#include "server/base/sort_unique.h"
#include "server/core/mesh/build/rest_plane.h"

namespace kerf::mesh {

// Numbers the different corners as vertices, by position and then by texture coordinate.
Result<ImportedSheet> assemble_as_first(const MeshFile& file, RestShape rest_shape) {
  using Corner = MeshFile::Corner;
  std::vector<std::array<Corner, 3>> triangles;
  ImportedSheet imported;
  imported.is_charted = file.corners.front().second != kNone;
  for (std::size_t f = 0; f < file.faces.size(); ++f) {
    const std::span<const Corner> corners = file.corners_of(file.faces[f]);
    for (const Corner& corner : corners) {
      if ((corner.second != kNone) == imported.is_charted) continue;
      return file.refuse("MIXED_TEXTURE", "some face corners have a texture coordinate and others do not");
    }
    for (std::size_t i = 2; i < corners.size(); ++i) {
      triangles.push_back({corners[0], corners[i - 1], corners[i]});
      imported.file_faces.push_back(static_cast<std::int32_t>(f));
    }
  }
  std::vector<Corner> vertices;
  vertices.reserve(3 * triangles.size());
  for (const std::array<Corner, 3>& triangle : triangles) {
    vertices.insert(vertices.end(), triangle.begin(), triangle.end());
  }
  sort_unique(vertices);
  const auto num_vertices = static_cast<Eigen::Index>(vertices.size());
  imported.world.resize(3, num_vertices);
  for (Eigen::Index v = 0; v < num_vertices; ++v) {
    imported.file_positions.push_back(vertices[v].first);
    imported.world.col(v) = file.positions[vertices[v].first];
  }
  imported.sheet.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto at = std::lower_bound(vertices.begin(), vertices.end(), triangles[t][k]);
      imported.sheet.triangles(k, static_cast<Eigen::Index>(t)) = static_cast<std::int32_t>(at - vertices.begin());
    }
  }
  if (imported.is_charted) {
    imported.sheet.rest.resize(2, num_vertices);
    for (Eigen::Index v = 0; v < num_vertices; ++v) imported.sheet.rest.col(v) = file.textures[vertices[v].second];
    if (rest_shape == RestShape::kSurface) imported.sheet.surface = imported.world;
    return imported;
  }
  PlaneFit fit = fit_plane(imported.world, imported.sheet.triangles);
  if (fit.rest) {
    imported.sheet.rest = std::move(*fit.rest);
  } else if (rest_shape == RestShape::kFlat) {
    return file.refuse("NOT_PLANAR", "the faces do not lie in one plane");
  } else {
    imported.sheet.surface = imported.world;
  }
  return imported;
}

}  // namespace kerf::mesh
