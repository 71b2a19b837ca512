#include "server/core/fem/element/wind_drag.h"

#include <cmath>

#include <Eigen/Geometry>

namespace kerf::fem {
namespace {

double limited(double rate, double duration_per_mass) {
  const double reach = rate * duration_per_mass;
  return rate / std::sqrt(1.0 + reach * reach);
}

}  // namespace

bool has_wind_drag(const Wind& wind) {
  return wind.air_density > 0.0 && !(wind.normal_drag == 0.0 && wind.tangential_drag == 0.0);
}

void add_wind_drag(std::span<const ElementBlock> blocks, const MaterialTable& materials, const Wind& wind,
                   double duration, const State& state, linear::VertexField& f) {
  if (!has_wind_drag(wind)) return;
  const double normal_factor = 0.5 * wind.air_density * wind.normal_drag;
  const double tangential_factor = 0.5 * wind.air_density * wind.tangential_drag;
  for (const ElementBlock& block : blocks) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (block.area[l] == 0.0) continue;
      const mesh::VertexId i = block.vertex[0][l];
      const mesh::VertexId j = block.vertex[1][l];
      const mesh::VertexId k = block.vertex[2][l];
      const Eigen::Vector3d d1 = state.x.col(j) - state.x.col(i);
      const Eigen::Vector3d d2 = state.x.col(k) - state.x.col(i);
      const Eigen::Vector3d twice_area = d1.cross(d2);
      const double twice_size = twice_area.norm();
      if (!(twice_size > 0.0)) continue;
      const Eigen::Vector3d n = twice_area / twice_size;
      const Eigen::Vector3d u = wind.velocity - (state.v.col(i) + state.v.col(j) + state.v.col(k)) * (1.0 / 3.0);
      const double un = u.dot(n);
      const Eigen::Vector3d ut = u - un * n;
      const double A = 0.5 * twice_size;
      const double normal_rate = A * normal_factor * std::abs(un);       // kg/s
      const double tangential_rate = A * tangential_factor * ut.norm();  // kg/s
      const double duration_per_mass = duration / (materials.of(block, l).surface_density * block.area[l]);
      const double cn = limited(normal_rate, duration_per_mass);
      const double ct = limited(tangential_rate, duration_per_mass);
      const Eigen::Vector3d third = (1.0 / 3.0) * (cn * un * n + ct * ut);
      f.col(i) += third;
      f.col(j) += third;
      f.col(k) += third;
    }
  }
}

}  // namespace kerf::fem
