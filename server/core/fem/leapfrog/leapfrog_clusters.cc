#include <algorithm>
#include <array>
#include <cmath>

#include "server/core/fem/leapfrog/leapfrog_sweep.h"
#include "server/core/fem/leapfrog/leapfrog_vertices.h"

// Members of LeapfrogSweep for clusters of local inertia and for grabbed points.
namespace kerf::fem {

using mesh::VertexId;

template <typename T>
void LeapfrogSweep<T>::accelerate_clusters(const Model& model, const LeapfrogStep<T>& step,
                                           const linear::VertexField* forces) {
  T* const force = entries(gathered_);
  T* const values = entries(cluster_values_);
  const std::array<T, 4> gravity{step.gravity[0], step.gravity[1], step.gravity[2], T{0}};
  for (const InertiaCluster* const cluster : inertia_->clusters()) {
    const std::span<const VertexId> vertices = cluster->vertices();
    const bool is_held = cluster->is_held();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto v = static_cast<std::size_t>(vertices[i]);
      std::copy_n(force + 4 * v, 4, values + 4 * i);
      if (forces != nullptr) sum += forces->col(vertices[i]);
      if (!is_held) continue;
      const auto mass = static_cast<T>(model.mass()[v]);
      for (std::size_t c = 0; c < 4; ++c) values[4 * i + c] += mass * gravity[c];
    }
    const std::array<T, 4> external{static_cast<T>(sum.x()), static_cast<T>(sum.y()), static_cast<T>(sum.z()), T{0}};
    cluster->solve(values, is_by_displacements() ? nullptr : &external);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto v = static_cast<std::size_t>(vertices[i]);
      std::copy_n(values + 4 * i, 4, force + 4 * v);
      for (std::size_t c = 0; is_held && c < 4; ++c) force[4 * v + c] -= gravity[c];
    }
  }
}

template <typename T>
void LeapfrogSweep<T>::set_response(const Grab& grab, const InertiaCluster& cluster) {
  const std::span<const VertexId> vertices = cluster.vertices();
  T* const values = entries(cluster_values_);
  std::fill_n(values, 4 * vertices.size(), T{0});
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] != vertices[i]) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        values[4 * i + c] += static_cast<T>(grab.weights[static_cast<Eigen::Index>(k)]);
      }
    }
  }
  cluster.solve(values);
}

template <typename T>
template <typename AtVertex, typename AtCluster>
void LeapfrogSweep<T>::for_each_grabbed(const Grab& grab, const AtVertex& at_vertex, const AtCluster& at_cluster) {
  std::array<const InertiaCluster*, 3> seen{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (grab.vertices[k] == mesh::kNone) continue;
    const InertiaCluster* const cluster = inertia_->cluster_of(grab.vertices[k]);
    if (cluster == nullptr) {
      at_vertex(grab.vertices[k], grab.weights[static_cast<Eigen::Index>(k)]);
    } else if (std::find(seen.begin(), seen.end(), cluster) == seen.end()) {
      seen[k] = cluster;
      set_response(grab, *cluster);
      at_cluster(*cluster);
    }
  }
}

template <typename T>
Eigen::Array3d LeapfrogSweep<T>::mobility(const Grab& grab) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for_each_grabbed(
      grab, [&](VertexId v, double weight) { sum += weight * weight * vector_at(mobility_, v).array(); },
      [&](const InertiaCluster& cluster) {
        for (std::size_t i = 0; i < cluster.vertices().size(); ++i) {
          for (std::size_t k = 0; k < 3; ++k) {
            if (grab.vertices[k] != cluster.vertices()[i]) continue;
            sum += grab.weights[static_cast<Eigen::Index>(k)] *
                   Eigen::Map<const Eigen::Array<T, 3, 1>>(entries(cluster_values_) + 4 * i).template cast<double>();
          }
        }
      });
  return sum;
}

template <typename T>
bool LeapfrogSweep<T>::push(const Grab& grab, const Eigen::Array3d& impulse, double drift) {
  bool is_inside = true;
  const auto push_vertex = [&](VertexId v, const Eigen::Vector3d& change) {
    set_velocity(v, velocity(v) + change);
    speed_.lane[0] = std::max(speed_.lane[0], static_cast<T>(velocity(v).cwiseAbs().maxCoeff()));
    is_inside = set_position(v, position(v) + drift * change) && is_inside;
  };
  for_each_grabbed(
      grab,
      [&](VertexId v, double weight) { push_vertex(v, weight * (vector_at(mobility_, v).array() * impulse).matrix()); },
      [&](const InertiaCluster& cluster) {
        for (std::size_t i = 0; i < cluster.vertices().size(); ++i) {
          const Eigen::Map<const Eigen::Array<T, 3, 1>> response(entries(cluster_values_) + 4 * i);
          push_vertex(cluster.vertices()[i], (response.template cast<double>() * impulse).matrix());
        }
      });
  return is_inside;
}

template void LeapfrogSweep<float>::accelerate_clusters(const Model& model, const LeapfrogStep<float>& step,
                                                        const linear::VertexField* forces);
template void LeapfrogSweep<double>::accelerate_clusters(const Model& model, const LeapfrogStep<double>& step,
                                                         const linear::VertexField* forces);
template Eigen::Array3d LeapfrogSweep<float>::mobility(const Grab& grab);
template Eigen::Array3d LeapfrogSweep<double>::mobility(const Grab& grab);
template bool LeapfrogSweep<float>::push(const Grab& grab, const Eigen::Array3d& impulse, double drift);
template bool LeapfrogSweep<double>::push(const Grab& grab, const Eigen::Array3d& impulse, double drift);

}  // namespace kerf::fem
