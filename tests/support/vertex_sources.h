#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::test {

// Checks that the rest position of each vertex in `sources` is the weighted mean of the positions before the edit.
// Describes the first fault, or returns nothing.
inline std::optional<std::string> find_wrong_source(const mesh::TriangleMesh& before, const mesh::TriangleMesh& after,
                                                    const std::vector<mesh::VertexSource>& sources) {
  const double allowed = 1e-12 * before.bounding_box().sizes().maxCoeff();
  for (const mesh::VertexSource& source : sources) {
    const std::string vertex = "vertex " + std::to_string(source.vertex);
    Eigen::Vector2d sum(0.0, 0.0);
    for (int k = 0; k < 3; ++k) {
      if (source.sources[k] < 0 || source.sources[k] >= before.num_vertices()) {
        return vertex + " has a source that is not an old vertex";
      }
      if (!(source.weights[k] >= 0.0)) return vertex + " has a weight that is not >= 0";
      sum += source.weights[k] * before.rest_position(source.sources[k]);
    }
    if (!(std::abs(source.weights.sum() - 1.0) <= 1e-14)) return vertex + " has weights that do not sum to 1";
    const double error = (sum - after.rest_position(source.vertex)).norm();
    if (!(error <= allowed)) return vertex + " is " + std::to_string(error / allowed) + " times the rounding off";
  }
  return std::nullopt;
}

}  // namespace kerf::test
