#include "server/core/mesh/build/facets.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "server/core/mesh/build/mesh_import.h"

namespace kerf::mesh {
namespace {

class FacetMaker {
 public:
  FacetMaker(const Eigen::Matrix3Xd& surface, MeshData& data, const ElementNames& names)
      : surface_(surface), data_(data), names_(names) {}

  Status run() {
    const auto count = static_cast<TriangleId>(data_.triangles.size());
    std::vector<std::int32_t> facet_of(data_.triangles.size(), kNone);
    RestSurface made;
    std::vector<TriangleId> stack;
    for (TriangleId first = 0; first < count; ++first) {
      if (is_degenerate(first)) {
        return invalid_argument(
            "MESH_DEGENERATE_TRIANGLE",
            names_.triangle(first) +
                " is a line on the rest surface, or its height is below a millionth of its longest edge",
            "surface");
      }
      if (facet_of[first] != kNone) continue;
      const auto number = static_cast<std::int32_t>(made.facets.size());
      const Facet facet = Facet::of(material_corners(first), surface_corners(first), data_.triangles[first].region);
      made.facets.push_back(facet);
      facet_of[first] = number;
      stack.push_back(first);
      while (!stack.empty()) {
        const TriangleRecord& record = data_.triangles[stack.back()];
        stack.pop_back();
        for (int k = 0; k < 3; ++k) {
          const TriangleId next = record.neighbours[k];
          if (next == kNone || record.locks[k] != 0 || facet_of[next] != kNone || !lies_on(facet, next)) continue;
          facet_of[next] = number;
          stack.push_back(next);
        }
      }
    }
    for (std::size_t t = 0; t < facet_of.size(); ++t) data_.triangles[t].region = facet_of[t];
    data_.surface = std::make_shared<const RestSurface>(std::move(made));
    return Nothing{};
  }

 private:
  [[nodiscard]] std::array<Eigen::Vector2d, 3> material_corners(TriangleId t) const {
    const std::array<PointId, 3>& p = data_.triangles[t].points;
    const auto at = [&](int k) { return data_.lattice.position(data_.points[p[k]].at); };
    return {at(0), at(1), at(2)};
  }

  [[nodiscard]] std::array<Eigen::Vector3d, 3> surface_corners(TriangleId t) const {
    const std::array<VertexId, 3>& v = data_.triangles[t].vertices;
    return {surface_.col(v[0]), surface_.col(v[1]), surface_.col(v[2])};
  }

  static double longest_edge(const std::array<Eigen::Vector3d, 3>& at) {
    return std::max({(at[1] - at[0]).norm(), (at[2] - at[1]).norm(), (at[0] - at[2]).norm()});
  }

  [[nodiscard]] bool is_degenerate(TriangleId t) const {
    const std::array<Eigen::Vector3d, 3> at = surface_corners(t);
    const double longest = longest_edge(at);
    return !((at[1] - at[0]).cross(at[2] - at[0]).norm() > kMinFlatness * longest * longest);
  }

  [[nodiscard]] bool lies_on(const Facet& facet, TriangleId t) const {
    if (data_.triangles[t].region != facet.region) return false;
    const std::array<Eigen::Vector2d, 3> material = material_corners(t);
    const std::array<Eigen::Vector3d, 3> at = surface_corners(t);
    const double allowed = kSameFacet * longest_edge(at);
    for (std::size_t k = 0; k < 3; ++k) {
      if ((facet.at(material[k]) - at[k]).norm() > allowed) return false;
    }
    return true;
  }

  const Eigen::Matrix3Xd& surface_;
  MeshData& data_;
  const ElementNames& names_;
};

}  // namespace

Status make_facets(const Eigen::Matrix3Xd& surface, MeshData& data, const ElementNames& names) {
  return FacetMaker(surface, data, names).run();
}

}  // namespace kerf::mesh
