#include "server/core/mesh/regions.h"

#include <map>
#include <memory>
#include <utility>

#include "server/base/check.h"

namespace kerf::mesh {

TriangleMesh with_regions(const TriangleMesh& mesh, std::span<const std::int32_t> regions) {
  KERF_CHECK(regions.size() == static_cast<std::size_t>(mesh.num_triangle_slots()), "one region a slot");
  MeshData data = mesh.data();
  RestSurface surface;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> facet_of;  // new facet, by old facet and new region
  for (std::size_t t = 0; t < regions.size(); ++t) {
    TriangleRecord& record = data.triangles[t];
    if (record.region == kNone) continue;
    KERF_CHECK(regions[t] >= 0, "regions have labels >= 0");
    if (!mesh.is_curved()) {
      record.region = regions[t];
      continue;
    }
    const auto number = static_cast<std::int32_t>(surface.facets.size());
    const auto [at, is_new] = facet_of.try_emplace({record.region, regions[t]}, number);
    if (is_new) {
      surface.facets.push_back(*mesh.facet(static_cast<TriangleId>(t)));
      surface.facets.back().region = regions[t];
    }
    record.region = at->second;
  }
  if (mesh.is_curved()) data.surface = std::make_shared<const RestSurface>(std::move(surface));
  return TriangleMesh(std::move(data));
}

}  // namespace kerf::mesh
