#include "server/core/fem/leapfrog/fine_triangles.h"

#include "server/core/fem/leapfrog/membrane_layout.h"

namespace kerf::fem {

void FineTriangles::set_lane(std::int32_t lane, bool is_fine) {
  std::int32_t& place = place_of_lane[static_cast<std::size_t>(lane)];
  if (is_fine == (place != mesh::kNone)) return;
  if (is_fine) {
    place = static_cast<std::int32_t>(lanes.size());
    lanes.push_back(lane);
    return;
  }
  place_of_lane[static_cast<std::size_t>(lanes.back())] = place;
  lanes[static_cast<std::size_t>(place)] = lanes.back();
  lanes.pop_back();
  place = mesh::kNone;
}

LeapfrogArrays<double> FineTriangles::arrays() {
  LeapfrogArrays<double> made;
  made.irregular = blocks;
  made.irregular_edges = edges.data();
  made.irregular_laws = laws.empty() ? nullptr : laws.data();
  made.corner_x = corner_x.front().lane.data();
  made.corner_force = corner_force.front().lane.data();
  return made;
}

void FineTriangles::set_forces() {
  const double* const from = corner_force.front().lane.data();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto place = static_cast<std::size_t>(corner_place(static_cast<std::int32_t>(i), k));
      float* const to = forces.data() + 4 * (3 * i + static_cast<std::size_t>(k));
      for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(from[4 * place + c]);
    }
  }
}

}  // namespace kerf::fem
