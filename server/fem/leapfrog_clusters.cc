#include <algorithm>
#include <array>
#include <cmath>

#include "server/fem/free_flight.h"
#include "server/fem/leapfrog_sweep.h"
#include "server/fem/leapfrog_vertices.h"

// Members of LeapfrogSweep that move what has local inertia, and points that are grabbed.
namespace kerf::fem {

using mesh::VertexId;

template <typename T>
void LeapfrogSweep<T>::move_clusters(const Model& model, const LeapfrogTerms& terms, const LeapfrogKick& kick) {
  const std::array<T, 3> gravity{static_cast<T>(terms.gravity.x()), static_cast<T>(terms.gravity.y()),
                                 static_cast<T>(terms.gravity.z())};
  const auto drift = static_cast<T>(kick.drift / unit_);
  const bool has_one_damping = mass_damping_.empty();
  const KickFactors common = kick_factors(has_one_damping ? model.mass_damping(0) : 0.0, kick.duration);
  const auto factors_of = [&](VertexId v) {
    return has_one_damping ? common : kick_factors(model.mass_damping(v), kick.duration);
  };
  const VertexChange vertex(*this);
  const T* const force = entries(gathered_);
  T* const values = entries(cluster_values_);
  std::array<T, 3> fastest{};
  for (const InertiaCluster* const cluster : inertia_->clusters()) {
    const std::span<const VertexId> vertices = cluster->vertices();
    const bool is_held = cluster->is_held();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto v = static_cast<std::size_t>(vertices[i]);
      const auto scale = static_cast<T>(factors_of(vertices[i]).scale);
      for (std::size_t c = 0; c < 4; ++c) values[4 * i + c] = scale * force[4 * v + c];
      if (!is_held) continue;
      const auto mass = static_cast<T>(model.mass()[v]);
      for (std::size_t c = 0; c < 3; ++c) values[4 * i + c] += scale * mass * gravity[c];
    }
    cluster->solve(values);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto v = static_cast<std::size_t>(vertices[i]);
      const KickFactors factors = factors_of(vertices[i]);
      const auto scale = static_cast<T>(is_held ? 0.0 : factors.scale);
      const auto lost = static_cast<T>(factors.lost);
      for (std::size_t c = 0; c < 3; ++c) {
        if ((cluster->held()[i] >> c & 1U) != 0) continue;
        const T change = values[4 * i + c] + scale * gravity[c] - lost * vertex.velocity(v, c);
        fastest[c] = std::max(fastest[c], std::abs(vertex.add(v, c, change, drift)));
      }
    }
  }
  for (std::size_t c = 0; c < 3; ++c) speed_.lane[c] = std::max(speed_.lane[c], fastest[c]);
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

template void LeapfrogSweep<float>::move_clusters(const Model& model, const LeapfrogTerms& terms,
                                                  const LeapfrogKick& kick);
template void LeapfrogSweep<double>::move_clusters(const Model& model, const LeapfrogTerms& terms,
                                                   const LeapfrogKick& kick);
template Eigen::Array3d LeapfrogSweep<float>::mobility(const Grab& grab);
template Eigen::Array3d LeapfrogSweep<double>::mobility(const Grab& grab);
template bool LeapfrogSweep<float>::push(const Grab& grab, const Eigen::Array3d& impulse, double drift);
template bool LeapfrogSweep<double>::push(const Grab& grab, const Eigen::Array3d& impulse, double drift);

}  // namespace kerf::fem
