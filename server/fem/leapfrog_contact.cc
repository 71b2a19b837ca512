#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "server/fem/contact_constraint.h"
#include "server/fem/leapfrog_sweep.h"
#include "server/fem/leapfrog_vertex_lanes.h"
#include "server/fem/leapfrog_vertices.h"

// Members of LeapfrogSweep that keep vertices out of bodies.
namespace kerf::fem {

using mesh::VertexId;

template <typename T>
bool LeapfrogSweep<T>::enforce(const Model& model, ContactConstraint& contact, double drift) {
  const std::span<const std::int32_t> due = contact.find_due_blocks(drift, farthest_moved(drift));
  if (due.empty()) return true;
  const LeapfrogArrays<T> arrays = this->arrays();
  bool is_inside = true;
  for (const std::int32_t block : due) {
    load_vertices(arrays, frame(), static_cast<std::size_t>(block), drift, contact_.vertices);
    is_inside = enforce_block(model, contact, arrays, block) && is_inside;
  }
  share_impulses();
  return is_inside;
}

template <typename T>
void LeapfrogSweep<T>::find_touching(ContactConstraint& contact, double drift) {
  const std::span<const std::int32_t> due = contact.find_due_blocks(drift, farthest_moved(drift));
  contact_.num_blocks = due.size();
  std::copy(due.begin(), due.end(), contact_.blocks.begin());
  const LeapfrogArrays<T> arrays = this->arrays();
  for (std::size_t k = 0; k < due.size(); ++k) {
    load_vertices(arrays, frame(), static_cast<std::size_t>(due[k]), drift, contact_.vertices);
    contact_.before[k] = contact_.vertices.before;
  }
}

template <typename T>
bool LeapfrogSweep<T>::enforce_found(const Model& model, ContactConstraint& contact) {
  const LeapfrogArrays<T> arrays = this->arrays();
  bool is_inside = true;
  for (std::size_t k = 0; k < contact_.num_blocks; ++k) {
    load_vertices(arrays, frame(), static_cast<std::size_t>(contact_.blocks[k]), 0.0, contact_.vertices);
    contact_.vertices.before = contact_.before[k];
    is_inside = enforce_block(model, contact, arrays, contact_.blocks[k]) && is_inside;
  }
  share_impulses();
  return is_inside;
}

template <typename T>
double LeapfrogSweep<T>::farthest_moved(double drift) const {
  const auto fastest = static_cast<double>(*std::max_element(speed_.lane.begin(), speed_.lane.end()));
  return std::sqrt(3.0) * (std::abs(drift) * fastest + unit_of_rounding());
}

template <typename T>
bool LeapfrogSweep<T>::enforce_block(const Model& model, ContactConstraint& contact, const LeapfrogArrays<T>& arrays,
                                     std::int32_t block) {
  const auto b = static_cast<std::size_t>(block);
  mesh::VertexLanes& vertices = contact_.vertices;
  const bool has_cluster = !has_cluster_.empty() && has_cluster_[b] != 0;
  if (has_cluster) contact_.v = vertices.v;
  const std::uint32_t changed = contact.enforce_block(block, vertices);
  if (changed == 0) return true;
  touched_ = true;
  if (has_cluster) gather_impulses(model, b, changed);
  return store_vertices(vertices, changed, frame(), b, arrays) <= kReach;
}

// Velocities of vertices in clusters stay for share_impulses().
template <typename T>
void LeapfrogSweep<T>::gather_impulses(const Model& model, std::size_t block, std::uint32_t changed) {
  mesh::VertexLanes& vertices = contact_.vertices;
  for (; changed != 0; changed &= changed - 1) {
    const auto l = static_cast<std::size_t>(std::countr_zero(changed));
    const std::size_t v = block * kBlockLanes + l;
    const InertiaCluster* const cluster = inertia_->cluster_of(static_cast<VertexId>(v));
    if (cluster == nullptr) continue;
    contact_.clusters.push_back(cluster);
    contact_.impulses.push_back({static_cast<VertexId>(v), {}});
    for (std::size_t c = 0; c < 3; ++c) {
      contact_.impulses.back().value[c] = static_cast<T>(model.mass()[v] * (vertices.v[c][l] - contact_.v[c][l]));
      vertices.v[c][l] = contact_.v[c][l];
    }
  }
}

// As leapfrog_kernels.cc does.
template <typename T>
void LeapfrogSweep<T>::add_velocity(std::size_t v, std::size_t component, T change) {
  T& velocity = at(v_[component], v);
  if constexpr (std::is_same_v<T, float>) {
    float& remainder = at(v_remainder_[component], v);
    const float all = change + remainder;
    const float after = velocity + all;
    remainder = all - (after - velocity);
    velocity = after;
  } else {
    velocity += change;
  }
}

template <typename T>
void LeapfrogSweep<T>::share_impulses() {
  if (contact_.clusters.empty()) return;
  T* const impulse = entries(gathered_);
  std::sort(contact_.clusters.begin(), contact_.clusters.end());
  contact_.clusters.erase(std::unique(contact_.clusters.begin(), contact_.clusters.end()), contact_.clusters.end());
  for (const InertiaCluster* const cluster : contact_.clusters) {
    for (const VertexId v : cluster->vertices()) std::fill_n(impulse + 4 * static_cast<std::size_t>(v), 4, T{0});
  }
  for (const Impulse& each : contact_.impulses) {
    std::copy(each.value.begin(), each.value.end(), impulse + 4 * static_cast<std::size_t>(each.vertex));
  }
  T* const values = entries(cluster_values_);
  for (const InertiaCluster* const cluster : contact_.clusters) {
    const std::span<const VertexId> vertices = cluster->vertices();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      std::copy_n(impulse + 4 * static_cast<std::size_t>(vertices[i]), 4, values + 4 * i);
    }
    cluster->solve(values);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        if ((cluster->held()[i] >> c & 1U) != 0) continue;
        add_velocity(static_cast<std::size_t>(vertices[i]), c, values[4 * i + c]);
      }
    }
  }
  contact_.clusters.clear();
  contact_.impulses.clear();
}

template bool LeapfrogSweep<float>::enforce(const Model& model, ContactConstraint& contact, double drift);
template bool LeapfrogSweep<double>::enforce(const Model& model, ContactConstraint& contact, double drift);
template void LeapfrogSweep<float>::find_touching(ContactConstraint& contact, double drift);
template void LeapfrogSweep<double>::find_touching(ContactConstraint& contact, double drift);
template bool LeapfrogSweep<float>::enforce_found(const Model& model, ContactConstraint& contact);
template bool LeapfrogSweep<double>::enforce_found(const Model& model, ContactConstraint& contact);

}  // namespace kerf::fem
