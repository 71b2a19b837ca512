#include "server/core/sheet/cluster_inertia.h"

#include <algorithm>

#include "server/core/fem/model/inertia_cluster.h"

namespace kerf::sheet {

void ClusterInertia::respond(std::size_t group, std::size_t place, std::span<Eigen::Array3d> velocities) const {
  const fem::InertiaCluster& cluster = *inertia_->clusters()[group];
  values_.assign(velocities.size() / 4 + 1, {});
  double* const values = values_.front().lane.data();
  std::fill_n(values + 4 * place, 3, 1.0);
  cluster.solve(values);
  for (std::size_t k = 0; k < velocities.size(); ++k) {
    velocities[k] = {values[4 * k], values[4 * k + 1], values[4 * k + 2]};
  }
}

}  // namespace kerf::sheet
