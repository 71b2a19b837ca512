#include "server/core/fem/leapfrog/cluster_push.h"

#include <algorithm>

#include <Eigen/Core>

namespace kerf::fem {

template <typename T>
void ClusterPush<T>::reserve(std::size_t num_vertices) {
  const std::size_t size = num_vertices / 4 + 1;
  if (size <= response_.size()) return;
  impulse_.resize(size);
  response_.resize(size);
}

template <typename T>
const T* ClusterPush<T>::respond(const InertiaCluster& cluster, const T* wanted) {
  using Four = Eigen::Array<T, 4, 1>;
  const std::size_t n = cluster.vertices().size();
  T* const response = response_.front().lane.data();
  const auto at = [](T* values, std::size_t i) { return Eigen::Map<Four, Eigen::Aligned16>(values + 4 * i); };
  const auto wanted_at = [&](std::size_t i) { return Eigen::Map<const Four, Eigen::Aligned16>(wanted + 4 * i); };
  const auto impulse_at = [&](std::size_t i) { return at(impulse_.front().lane.data(), i); };
  Four largest = Four::Zero();
  for (std::size_t i = 0; i < n; ++i) largest = largest.max(wanted_at(i).abs());
  // Wanted changes are divided by the largest component, because their squares may be too small for T.
  const T unit = largest.maxCoeff();
  if (!(unit > 0)) {
    std::fill_n(response, 4 * n, T{0});
    return response;
  }
  Four sum = Four::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Four share = wanted_at(i) / unit;
    at(response, i) = impulse_at(i) = static_cast<T>(cluster.mass(i)) * share;
    sum += impulse_at(i) * share;
  }
  cluster.solve(response);
  Four responded = Four::Zero();
  Four farthest = Four::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    responded += impulse_at(i) * at(response, i);
    if ((impulse_at(i) != T{0}).any()) farthest = farthest.max(at(response, i).abs());
  }
  const T wanted_energy = sum.sum();
  const T energy = responded.sum();
  const T most = farthest.maxCoeff();
  const T scale = energy > 0 && most > 0 ? std::min(wanted_energy / energy, T{1} / most) : T{0};
  for (std::size_t i = 0; i < n; ++i) at(response, i) *= unit * scale;
  return response;
}

template class ClusterPush<float>;
template class ClusterPush<double>;

}  // namespace kerf::fem
