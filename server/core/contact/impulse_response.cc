#include "server/core/contact/impulse_response.h"

#include <algorithm>

#include "server/base/check.h"

namespace kerf::contact {

using mesh::VertexId;

void ImpulseResponse::resize(std::size_t num_vertices) {
  inverse_mass_.assign(num_vertices, 0.0);
  group_.assign(num_vertices, -1);
  place_.assign(num_vertices, 0);
  first_.assign(num_vertices, -1);
  grouped_.clear();
}

void ImpulseResponse::begin(std::span<const double> inverse_mass, const SharedInertia* shared) {
  KERF_CHECK(inverse_mass.size() == inverse_mass_.size(), "resize() was called for this topology");
  std::copy(inverse_mass.begin(), inverse_mass.end(), inverse_mass_.begin());
  for (const VertexId v : grouped_) group_[static_cast<std::size_t>(v)] = first_[static_cast<std::size_t>(v)] = -1;
  grouped_.clear();
  velocities_.clear();
  shared_ = shared;
  if (shared == nullptr) return;
  for (std::size_t group = 0; group < shared->num_groups(); ++group) {
    std::int32_t place = 0;
    for (const VertexId v : shared->vertices(group)) {
      group_[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(group);
      place_[static_cast<std::size_t>(v)] = place++;
      grouped_.push_back(v);
    }
  }
}

std::span<const Eigen::Array3d> ImpulseResponse::velocities_of(VertexId v) {
  const auto i = static_cast<std::size_t>(v), group = static_cast<std::size_t>(group_[i]);
  const std::size_t size = shared_->vertices(group).size();
  if (first_[i] < 0) {
    first_[i] = static_cast<std::int32_t>(velocities_.size());
    velocities_.resize(velocities_.size() + size);
    shared_->respond(group, static_cast<std::size_t>(place_[i]), std::span(velocities_).last(size));
  }
  return std::span<const Eigen::Array3d>(velocities_).subspan(static_cast<std::size_t>(first_[i]), size);
}

double ImpulseResponse::mobility(std::span<const VertexId> vertices, std::span<const double> weights,
                                 const Eigen::Vector3d& normal) {
  double sum = 0.0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const double inverse = inverse_mass(vertices[i]);
    if (weights[i] == 0.0 || inverse == 0.0) continue;
    if (!is_shared(vertices[i])) {
      sum += weights[i] * weights[i] * inverse;
      continue;
    }
    const std::span<const Eigen::Array3d> velocities = velocities_of(vertices[i]);
    for (std::size_t j = 0; j < vertices.size(); ++j) {
      const auto v = static_cast<std::size_t>(vertices[j]);
      if (group_[v] != group_[static_cast<std::size_t>(vertices[i])] || inverse_mass_[v] == 0.0) continue;
      sum +=
          weights[i] * weights[j] * (normal.array().square() * velocities[static_cast<std::size_t>(place_[v])]).sum();
    }
  }
  return sum;
}

}  // namespace kerf::contact
