#include "render/sheet_shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kerf::render {

Float3 unit(Float3 v, Float3 otherwise) {
  double square = 0.0;
  for (const float component : v) square += static_cast<double>(component) * static_cast<double>(component);
  const auto scale = static_cast<float>(1.0 / std::sqrt(square));
  return square > 0.0 && std::isfinite(scale) ? Float3{scale * v[0], scale * v[1], scale * v[2]} : otherwise;
}

std::vector<Float3> vertex_normals(const Mesh& mesh) {
  std::vector<Float3> normals(mesh.positions.size() / 3, Float3{});
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Float3 a = position(mesh, mesh.triangles[t]);
    const Float3 n = cross(difference(position(mesh, mesh.triangles[t + 1]), a),
                           difference(position(mesh, mesh.triangles[t + 2]), a));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Float3& sum = normals[static_cast<std::size_t>(mesh.triangles[t + corner])];
      for (std::size_t k = 0; k < 3; ++k) sum[k] += n[k];
    }
  }
  for (Float3& n : normals) n = unit(n, {0.0F, 0.0F, 1.0F});
  return normals;
}

std::vector<float> ridges(const Mesh& mesh, const std::vector<Float3>& normals, double length) {
  struct Sum {
    float curvature = 0.0F;  // 1/m, sum over the vertex's edges; edges inside the sheet count twice.
    float edges = 0.0F;
  };
  std::vector<Sum> sums(normals.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::int32_t from = mesh.triangles[i];
    const std::int32_t to = mesh.triangles[i % 3 == 2 ? i - 2 : i + 1];
    const Float3 along = difference(position(mesh, to), position(mesh, from));
    const float square = dot(along, along);
    if (!(square > 0.0F)) continue;
    const auto a = static_cast<std::size_t>(from);
    const auto b = static_cast<std::size_t>(to);
    const float curvature = dot(difference(normals[b], normals[a]), along) / square;
    for (const std::size_t end : {a, b}) {
      sums[end].curvature += curvature;
      sums[end].edges += 1.0F;
    }
  }
  std::vector<float> heights(normals.size(), 0.0F);
  for (std::size_t v = 0; v < sums.size(); ++v) {
    if (sums[v].edges == 0.0F) continue;
    heights[v] = std::clamp(sums[v].curvature / sums[v].edges * static_cast<float>(length), -1.0F, 1.0F);
  }
  return heights;
}

}  // namespace kerf::render
