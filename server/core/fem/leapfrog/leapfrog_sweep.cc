#include "server/core/fem/leapfrog/leapfrog_sweep.h"

#include "server/core/fem/leapfrog/leapfrog_vertex_lanes.h"

#include <algorithm>
#include <cmath>

#include "server/core/fem/leapfrog/leapfrog_vertices.h"
#include "server/core/fem/model/free_flight.h"

namespace kerf::fem {

using mesh::VertexId;

template <typename T>
LeapfrogArrays<T> LeapfrogSweep<T>::arrays() {
  LeapfrogArrays<T> arrays;
  arrays.num_blocks = layout_->num_blocks();
  arrays.offsets = layout_->offsets();
  arrays.x = entries(x_, 3 * pad_);
  arrays.v = entries(v_);
  arrays.remainder = entries(remainder_);
  arrays.v_remainder = entries(v_remainder_);
  const std::array<T*, 3> mobility = entries(mobility_);
  arrays.mobility = {mobility[0], mobility[1], mobility[2]};
  if (!quads_before_.empty()) {
    arrays.quads = quads_.data();
    arrays.quad_edges = quad_edges_.data();
    arrays.quads_before = quads_before_.data();
    for (std::size_t k = 0; k < 4; ++k) arrays.quad_force[k] = entries(quad_force_[k]);
    arrays.quad_ring = static_cast<std::ptrdiff_t>((quad_force_[0][0].size() - 1) * linear::kBlockLanes);
    arrays.quad_reach = static_cast<std::ptrdiff_t>(pad_);
  }
  arrays.irregular = irregular_;
  arrays.irregular_edges = irregular_edges_.data();
  if (is_by_displacements()) {
    arrays.quad_start = quad_start_.data();
    arrays.irregular_start = irregular_start_.data();
  }
  arrays.quad_laws = quad_laws_.empty() ? nullptr : quad_laws_.data();
  arrays.irregular_laws = irregular_laws_.empty() ? nullptr : irregular_laws_.data();
  arrays.mass_damping = entries(mass_damping_);
  arrays.has_cluster = has_cluster_.empty() ? nullptr : has_cluster_.data();
  arrays.corner_x = entries(corner_x_);
  arrays.corner_force = entries(corner_force_) + linear::kBlockLanes;  // after the zeros that kNoCorner reads
  arrays.gathered = entries(gathered_);
  arrays.bending_x = entries(bending_x_, 1);
  arrays.bending_fours = entries(bending_fours_);
  arrays.num_quads = layout_->num_quads();
  arrays.num_corners = layout_->num_corners();
  arrays.corners = &layout_->corners();
  return arrays;
}

template <typename T>
LeapfrogStep<T> LeapfrogSweep<T>::step_of(const Model& model, const LeapfrogTerms& terms) const {
  const std::array<double, 4> law = law_entries(model.materials()[0]);
  LeapfrogStep<T> step;
  step.membrane_law = model.materials().membrane_law();
  for (std::size_t k = 0; k < law.size(); ++k) step.law[k] = static_cast<T>(law[k]);
  step.damping = static_cast<T>(damping_of(terms.damping, 0) / terms.h);
  step.bending_damping = static_cast<T>(terms.bending_damping / unit_);
  return step;
}

template <typename T>
bool LeapfrogSweep<T>::begin(const Model& model, const Loads& loads, const LeapfrogTerms& terms, double duration,
                             const State& state) {
  contact_.moved = 0.0;
  set_mobility(model, loads);
  set_laws(model, terms);
  if (!set_frame(model, terms, duration, state)) return false;
  set_unit_of_constants();
  if (is_by_displacements() && !set_start(model, state)) return false;
  // Loads positions one substep back, so that the rate of strain in the first kick is that of the velocities.
  for (VertexId v = 0; v < layout_->num_vertices(); ++v) {
    if (takes_part_[static_cast<std::size_t>(v)] == 0) continue;
    if (!set_position(v, state.x.col(v) - terms.h * state.v.col(v))) return false;
  }
  tension_ = static_cast<double>(leapfrog_start(arrays(), step_of(model, terms)));
  if (!fine_.empty()) {
    set_fine_positions();
    tension_ = std::max(tension_, leapfrog_irregular(fine_.arrays(), fine_step(model, terms)));
  }
  return read(state);
}

template <typename T>
void LeapfrogSweep<T>::set_mobility(const Model& model, const Loads& loads) {
  const std::span<const double> inverse_mass = model.inverse_mass();
  for (std::size_t v = 0; v < takes_part_.size(); ++v) {
    const double mobility = v < inverse_mass.size() ? inverse_mass[v] : 0.0;
    takes_part_[v] = mobility > 0.0 ? 1 : 0;
    for (std::size_t c = 0; c < 3; ++c) at(mobility_[c], v) = static_cast<T>(mobility);
  }
  for (const Pin& pin : loads.pins) {
    const auto v = static_cast<std::size_t>(pin.vertex);
    takes_part_[v] = 1;
    for (std::size_t c = 0; c < 3; ++c) {
      if (pin.fixed[c]) at(mobility_[c], v) = 0;
    }
  }
  std::fill(has_cluster_.begin(), has_cluster_.end(), 0);
  for (const InertiaCluster* const cluster : inertia_->clusters()) {
    for (std::size_t k = 0; k < cluster->vertices().size(); ++k) {
      const auto v = static_cast<std::size_t>(cluster->vertices()[k]);
      has_cluster_[v / linear::kBlockLanes] = 1;
      for (std::size_t c = 0; c < 3; ++c) at(mobility_[c], v) = (cluster->held()[k] >> c & 1U) != 0 ? T{0} : T{1};
    }
  }
}

template <typename T>
void LeapfrogSweep<T>::set_fine_positions() {
  double* to = fine_.corner_x.front().lane.data();
  for (const VertexId v : fine_.vertices) {
    const auto i = static_cast<std::size_t>(v);
    const Eigen::Vector3d start = (base(v) - origin_) / unit_;
    for (std::size_t c = 0; c < 3; ++c) {
      to[c] = start[static_cast<Eigen::Index>(c)] + static_cast<double>(at(x_[c], 3 * pad_ * linear::kBlockLanes + i)) +
              static_cast<double>(at(remainder_[c], i));
    }
    to += 4;
  }
}

template <typename T>
LeapfrogStep<double> LeapfrogSweep<T>::fine_step(const Model& model, const LeapfrogTerms& terms) const {
  const std::array<double, 4> law = law_entries(model.materials()[0]);
  LeapfrogStep<double> step;
  step.membrane_law = model.materials().membrane_law();
  step.law = law;
  step.damping = damping_of(terms.damping, 0) / terms.h;
  return step;
}

template <typename T>
void LeapfrogSweep<T>::substep(const Model& model, const LeapfrogTerms& terms, const LeapfrogKick& kick) {
  fastest_ = std::max(fastest_, *std::max_element(speed_.lane.begin(), speed_.lane.end()));
  speed_ = {};
  LeapfrogStep<T> step = step_of(model, terms);
  const bool same_damping = model.materials().has_one_mass_damping();
  const KickFactors factors = kick_factors(same_damping ? model.masses().damping(0) : 0.0, kick.duration);
  step.lost = static_cast<T>(factors.lost);
  step.scale = static_cast<T>(factors.scale);
  for (std::size_t c = 0; c < 3; ++c) step.gravity[c] = static_cast<T>(terms.gravity[static_cast<int>(c)]);
  step.drift = static_cast<T>(kick.drift / unit_);
  step.bending_scale = static_cast<T>(kick.bending / kick.duration * unit_);
  LeapfrogArrays<T> with = arrays();
  if (kick.bending > 0.0 && model.materials().has_bending()) with.bending = &bending_;
  if (set_extra_forces(model, kick)) with.extra_force = entries(extra_);
  if (!fine_.empty()) {
    set_fine_positions();
    leapfrog_irregular(fine_.arrays(), fine_step(model, terms));
    fine_.set_forces();
    with.fine_places = fine_.places;
    if constexpr (std::is_same_v<T, float>) with.fine_force = fine_.forces.data();
  }
  leapfrog_substep(with, step, speed_.lane.data());
  if (has_cluster_.empty()) return;
  accelerate_clusters(model, step, kick.forces);
  leapfrog_move_clusters(with, step, speed_.lane.data());
}

template <typename T>
bool LeapfrogSweep<T>::set_position(VertexId v, const Eigen::Vector3d& position) {
  // Adding and subtracting this rounds to the nearest whole number.
  constexpr double kRounding = 0x1.8p52;
  const auto i = static_cast<std::size_t>(v);
  const double per_metre = 1.0 / unit_;  // exact, a power of two
  const Eigen::Vector3d from = base(v);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto axis = static_cast<Eigen::Index>(c);
    Position& x = at(x_[c], 3 * pad_ * linear::kBlockLanes + i);
    if constexpr (std::is_same_v<T, float>) {
      const double all = (position[axis] - from[axis]) * per_metre;
      if (!(std::abs(all) <= kReach)) return false;
      const double whole = (all + kRounding) - kRounding;
      x = static_cast<std::int32_t>(whole);
      at(remainder_[c], i) = static_cast<float>(all - whole);
    } else {
      x = position[axis];
    }
    entries(corner_x_)[4 * i + c] = x;
  }
  return true;
}

template <typename T>
void LeapfrogSweep<T>::set_velocity(VertexId v, const Eigen::Vector3d& velocity) {
  const auto i = static_cast<std::size_t>(v);
  for (std::size_t c = 0; c < 3; ++c) {
    const double all = velocity[static_cast<Eigen::Index>(c)];
    at(v_[c], i) = static_cast<T>(all);
    if constexpr (std::is_same_v<T, float>) {
      at(v_remainder_[c], i) = static_cast<float>(all - static_cast<double>(at(v_[c], i)));
    }
  }
}

template <typename T>
bool LeapfrogSweep<T>::read(const State& state) {
  for (std::size_t i = 0; i < takes_part_.size(); ++i) {
    const auto v = static_cast<VertexId>(i);
    const bool takes_part = takes_part_[i] != 0;
    if (!set_position(v, takes_part ? Eigen::Vector3d(state.x.col(v)) : base(v))) return false;
    set_velocity(v, takes_part ? Eigen::Vector3d(state.v.col(v)) : Eigen::Vector3d::Zero());
  }
  return true;
}

template <typename T>
bool LeapfrogSweep<T>::set_vertices(std::span<const VertexId> vertices, const State& state) {
  for (const VertexId v : vertices) {
    contact_.moved = std::max(contact_.moved, (state.x.col(v) - position(v)).norm());
    if (!set_position(v, state.x.col(v))) return false;
    set_velocity(v, state.v.col(v));
  }
  return true;
}

template <typename T>
void LeapfrogSweep<T>::write(State& state) {
  const LeapfrogArrays<T> arrays = this->arrays();
  const auto count = static_cast<std::size_t>(layout_->num_vertices());
  for (std::size_t first = 0; first < count; first += linear::kBlockLanes) {
    const std::size_t end = std::min(first + linear::kBlockLanes, count);
    const auto begin = takes_part_.begin() + static_cast<std::ptrdiff_t>(first);
    if (end == first + linear::kBlockLanes &&
        std::all_of(begin, begin + linear::kBlockLanes, [](std::uint8_t takes_part) { return takes_part != 0; })) {
      write_vertices(arrays, frame(), first / linear::kBlockLanes, state.x.data(), state.v.data());
      continue;
    }
    for (std::size_t i = first; i < end; ++i) {
      if (takes_part_[i] == 0) continue;
      const auto v = static_cast<VertexId>(i);
      state.x.col(v) = position(v);
      state.v.col(v) = velocity(v);
    }
  }
}

template <typename T>
Eigen::Vector3d LeapfrogSweep<T>::position(VertexId v) const {
  const auto i = static_cast<std::size_t>(v);
  const std::size_t from = 3 * pad_ * linear::kBlockLanes + i;
  const Eigen::Vector3d start = base(v);
  Eigen::Vector3d x;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto axis = static_cast<Eigen::Index>(c);
    if constexpr (std::is_same_v<T, float>) {
      x[axis] = start[axis] + unit_ * (at(x_[c], from) + static_cast<double>(at(remainder_[c], i)));
    } else {
      x[axis] = at(x_[c], from);
    }
  }
  return x;
}

template <typename T>
Eigen::Vector3d LeapfrogSweep<T>::velocity(VertexId v) const {
  if constexpr (std::is_same_v<T, float>) return vector_at(v_, v) + vector_at(v_remainder_, v);
  return vector_at(v_, v);
}

template class LeapfrogSweep<float>;
template class LeapfrogSweep<double>;

}  // namespace kerf::fem
