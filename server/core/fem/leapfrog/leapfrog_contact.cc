#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/leapfrog/leapfrog_sweep.h"
#include "server/core/fem/leapfrog/leapfrog_vertex_lanes.h"
#include "server/core/fem/leapfrog/leapfrog_vertices.h"

// Members of LeapfrogSweep that keep vertices out of bodies.
namespace kerf::fem {

using mesh::VertexId;

template <typename T>
bool LeapfrogSweep<T>::enforce(ContactConstraint& contact, double drift) {
  const std::span<const std::int32_t> due = contact.find_due_blocks(drift, farthest_moved(drift));
  contact_.moved = 0.0;
  if (due.empty()) return true;
  const LeapfrogArrays<T> arrays = this->arrays();
  bool is_inside = true;
  for (const std::int32_t block : due) {
    load_vertices(arrays, frame(), static_cast<std::size_t>(block), drift, contact_.vertices);
    is_inside = enforce_block(contact, arrays, block) && is_inside;
  }
  return push_clusters(drift) && is_inside;
}

template <typename T>
void LeapfrogSweep<T>::find_touching(ContactConstraint& contact, double drift) {
  const std::span<const std::int32_t> due = contact.find_due_blocks(drift, farthest_moved(drift));
  contact_.moved = 0.0;
  contact_.drift = drift;
  contact_.num_blocks = due.size();
  std::copy(due.begin(), due.end(), contact_.blocks.begin());
  const LeapfrogArrays<T> arrays = this->arrays();
  for (std::size_t k = 0; k < due.size(); ++k) {
    load_vertices(arrays, frame(), static_cast<std::size_t>(due[k]), drift, contact_.vertices);
    contact_.before[k] = contact_.vertices.before;
  }
}

template <typename T>
bool LeapfrogSweep<T>::enforce_found(ContactConstraint& contact) {
  const LeapfrogArrays<T> arrays = this->arrays();
  bool is_inside = true;
  for (std::size_t k = 0; k < contact_.num_blocks; ++k) {
    load_vertices(arrays, frame(), static_cast<std::size_t>(contact_.blocks[k]), 0.0, contact_.vertices);
    contact_.vertices.before = contact_.before[k];
    is_inside = enforce_block(contact, arrays, contact_.blocks[k]) && is_inside;
  }
  if (contact_.slots.empty()) return is_inside;
  return push_clusters(contact_.drift) && enforce_rest(contact) && is_inside;
}

template <typename T>
bool LeapfrogSweep<T>::enforce_rest(ContactConstraint& contact) {
  const LeapfrogArrays<T> arrays = this->arrays();
  bool is_inside = true;
  for (const std::int32_t block : contact.find_due_blocks(0.0, contact_.moved)) {
    mesh::VertexLanes& vertices = contact_.vertices;
    load_vertices(arrays, frame(), static_cast<std::size_t>(block), 0.0, vertices);
    contact_.given.v = vertices.v;
    const std::uint32_t changed = contact.enforce_block(block, vertices);
    vertices.v = contact_.given.v;
    is_inside =
        store_vertices(vertices, changed, frame(), static_cast<std::size_t>(block), arrays) <= kReach && is_inside;
  }
  contact_.moved = 0.0;
  return is_inside;
}

template <typename T>
double LeapfrogSweep<T>::farthest_moved(double drift) const {
  const auto fastest = static_cast<double>(*std::max_element(speed_.lane.begin(), speed_.lane.end()));
  return std::sqrt(3.0) * (std::abs(drift) * fastest + unit_of_rounding()) + contact_.moved;
}

template <typename T>
bool LeapfrogSweep<T>::enforce_block(ContactConstraint& contact, const LeapfrogArrays<T>& arrays, std::int32_t block) {
  const auto b = static_cast<std::size_t>(block);
  mesh::VertexLanes& vertices = contact_.vertices;
  const bool has_cluster = !has_cluster_.empty() && has_cluster_[b] != 0;
  if (has_cluster) contact_.given = vertices;
  const std::uint32_t changed = contact.enforce_block(block, vertices);
  if (changed == 0) return true;
  touched_ = true;
  if (has_cluster) gather_pushes(b, changed);
  return store_vertices(vertices, changed, frame(), b, arrays) <= kReach;
}

// Moves what a body did to vertices in clusters into contact_.pushes, and undoes it in contact_.vertices.
// push_clusters() then moves the clusters.
template <typename T>
void LeapfrogSweep<T>::gather_pushes(std::size_t block, std::uint32_t changed) {
  mesh::VertexLanes& vertices = contact_.vertices;
  const mesh::VertexLanes& given = contact_.given;
  for (; changed != 0; changed &= changed - 1) {
    const auto l = static_cast<std::size_t>(std::countr_zero(changed));
    const auto v = static_cast<VertexId>(block * linear::kBlockLanes + l);
    const std::int32_t slot = inertia_->slot_of(v);
    if (slot == mesh::kNone) continue;
    std::int32_t& first = contact_.first_push[static_cast<std::size_t>(slot)];
    if (first == mesh::kNone) contact_.slots.push_back(slot);
    Push push{v, first, {}, {}};
    first = static_cast<std::int32_t>(contact_.pushes.size());
    double squared = 0.0;  // m^2
    for (std::size_t c = 0; c < 3; ++c) {
      const double change = vertices.x[c][l] - given.x[c][l];
      squared += change * change;
      push.velocity[c] = static_cast<T>(vertices.v[c][l] - given.v[c][l]);
      push.position[c] = static_cast<T>(change);
      vertices.v[c][l] = given.v[c][l];
      vertices.x[c][l] = given.x[c][l];
    }
    // Contact counts distances from the position that it required.
    contact_.moved = std::max(contact_.moved, std::sqrt(squared));
    contact_.pushes.push_back(push);
  }
}

// Adds with compensation as in leapfrog_kernels.cc.
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
bool LeapfrogSweep<T>::add_position(std::size_t v, const Eigen::Vector3d& change) {
  bool is_inside = true;
  for (std::size_t c = 0; c < 3; ++c) {
    Position& x = at(x_[c], 3 * pad_ * linear::kBlockLanes + v);
    if constexpr (std::is_same_v<T, float>) {
      const double all = x + static_cast<double>(at(remainder_[c], v)) + change[static_cast<Eigen::Index>(c)] / unit_;
      if (!(std::abs(all) <= kReach)) {
        is_inside = false;
        continue;
      }
      x = static_cast<std::int32_t>(std::lrint(all));
      at(remainder_[c], v) = static_cast<float>(all - x);
    } else {
      x += change[static_cast<Eigen::Index>(c)];
    }
    entries(corner_x_)[4 * v + c] = x;
  }
  return is_inside;
}

template <typename T>
void LeapfrogSweep<T>::set_wanted(std::int32_t slot, std::array<T, 3> Push::*change) {
  const std::span<const VertexId> vertices = inertia_->cluster_in(slot).vertices();
  T* const of_all = entries(gathered_);
  for (const VertexId v : vertices) std::fill_n(of_all + 4 * static_cast<std::size_t>(v), 4, T{0});
  for (std::int32_t k = contact_.first_push[static_cast<std::size_t>(slot)]; k != mesh::kNone;) {
    const Push& push = contact_.pushes[static_cast<std::size_t>(k)];
    std::copy_n((push.*change).begin(), 3, of_all + 4 * static_cast<std::size_t>(push.vertex));
    k = push.next;
  }
  T* const values = entries(cluster_values_);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    std::copy_n(of_all + 4 * static_cast<std::size_t>(vertices[i]), 4, values + 4 * i);
  }
}

template <typename T>
bool LeapfrogSweep<T>::move_cluster(std::span<const VertexId> vertices, const T* change, double factor,
                                    double& travel) {
  bool is_inside = true;
  double farthest = 0.0;  // m^2
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3d moved =
        factor * Eigen::Map<const Eigen::Matrix<T, 3, 1>>(change + 4 * i).template cast<double>();
    farthest = std::max(farthest, moved.squaredNorm());
    is_inside = add_position(static_cast<std::size_t>(vertices[i]), moved) && is_inside;
  }
  travel += std::sqrt(farthest);
  return is_inside;
}

// Moves pushed clusters as a whole. If one vertex were pushed by its mass alone it would hardly stop its cluster. If it
// were moved alone it would strain the cluster. A cluster at rest on a body moves by its change of velocity during the
// drift, an arriving one less far.
template <typename T>
bool LeapfrogSweep<T>::push_clusters(double drift) {
  constexpr auto kLeft = static_cast<T>(0.25);  // -, part of the largest wanted displacement that may be left to the
                                                // next substep
  bool is_inside = true;
  double farthest = 0.0;  // m, largest travel of a vertex
  num_cluster_pushes_ += static_cast<int>(contact_.slots.size());
  for (const std::int32_t slot : contact_.slots) {
    const InertiaCluster& cluster = inertia_->cluster_in(slot);
    const std::span<const VertexId> vertices = cluster.vertices();
    double travel = 0.0;
    set_wanted(slot, &Push::velocity);
    const T* change = contact_.push.respond(cluster, entries(cluster_values_));
    T* const of_all = entries(gathered_);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto v = static_cast<std::size_t>(vertices[i]);
      for (std::size_t c = 0; c < 3; ++c) add_velocity(v, c, change[4 * i + c]);
      std::copy_n(change + 4 * i, 3, of_all + 4 * v);
    }
    is_inside = move_cluster(vertices, change, drift, travel) && is_inside;
    T most = 0, left = 0;
    for (std::int32_t k = contact_.first_push[static_cast<std::size_t>(slot)]; k != mesh::kNone;) {
      Push& push = contact_.pushes[static_cast<std::size_t>(k)];
      for (std::size_t c = 0; c < 3; ++c) {
        most = std::max(most, std::abs(push.position[c]));
        push.position[c] -= static_cast<T>(drift) * of_all[4 * static_cast<std::size_t>(push.vertex) + c];
        left = std::max(left, std::abs(push.position[c]));
      }
      k = push.next;
    }
    if (left > kLeft * most) {
      set_wanted(slot, &Push::position);
      change = contact_.push.respond(cluster, entries(cluster_values_));
      is_inside = move_cluster(vertices, change, 1.0, travel) && is_inside;
    }
    farthest = std::max(farthest, travel);
    contact_.first_push[static_cast<std::size_t>(slot)] = mesh::kNone;
  }
  contact_.moved += farthest;
  contact_.slots.clear();
  contact_.pushes.clear();
  return is_inside;
}

template bool LeapfrogSweep<float>::enforce(ContactConstraint& contact, double drift);
template bool LeapfrogSweep<double>::enforce(ContactConstraint& contact, double drift);
template void LeapfrogSweep<float>::find_touching(ContactConstraint& contact, double drift);
template void LeapfrogSweep<double>::find_touching(ContactConstraint& contact, double drift);
template bool LeapfrogSweep<float>::enforce_found(ContactConstraint& contact);
template bool LeapfrogSweep<double>::enforce_found(ContactConstraint& contact);

}  // namespace kerf::fem
