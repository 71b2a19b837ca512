#include "server/core/sheet/contact_bridge.h"

#include <algorithm>

namespace kerf::sheet {

void ContactBridge::set_vertices(std::int32_t num_vertices, const std::vector<mesh::VertexId>& pinned,
                                 const std::vector<mesh::VertexId>& removed) {
  for (const mesh::VertexId v : excluded_) is_excluded_[static_cast<std::size_t>(v)] = 0;
  excluded_ = pinned;
  excluded_.insert(excluded_.end(), removed.begin(), removed.end());
  is_excluded_.resize(static_cast<std::size_t>(num_vertices), 0);
  for (const mesh::VertexId v : excluded_) is_excluded_[static_cast<std::size_t>(v)] = 1;
  x_before_.resize(num_vertices);
  solver_.reserve(num_vertices);
}

void ContactBridge::set_self_contact(const scene::SelfContact& settings) {
  settings_ = settings;
  self_contact_.set_friction(settings.friction);
}

void ContactBridge::set_mesh(const mesh::TriangleMesh& mesh) {
  if (touches_itself()) self_contact_.set(mesh);
}

std::span<const mesh::VertexId> ContactBridge::begin_self_contact(double h, int substeps,
                                                                  const Eigen::Vector3d& gravity,
                                                                  std::span<const double> inverse_mass,
                                                                  const fem::LocalInertia& inertia, fem::State& state) {
  clusters_.set(inertia);
  self_contact_.set_thickness(self_thickness());
  self_contact_.set_bodies(&solver_);  // set here, since the bridge is copied
  self_contact_.begin({h, substeps, gravity, inverse_mass, inertia.empty() ? nullptr : &clusters_}, state.x, state.v);
  return self_contact_.moved();
}

std::span<const mesh::VertexId> ContactBridge::make_self_contact(fem::State& state) {
  self_contact_.make_phase(state.x, state.v);
  return self_contact_.moved();
}

void ContactBridge::end_self_contact(fem::State& state) {
  self_contact_.end(state.x, state.v);
  x_before_ = state.x;
}

fem::SelfContactStats ContactBridge::take_self_stats(const linear::VertexField& x) {
  const contact::SelfContactCounters& now = self_contact_.counters();
  const contact::SelfContactCounters& before = before_;
  return {.phases = now.phases - before.phases,
          .searches = now.searches - before.searches,
          .late = now.late - before.late,
          .pairs = now.pairs - before.pairs,
          .contacts = now.contacts - before.contacts,
          .repairs = now.repairs - before.repairs,
          .zones = now.zones - before.zones,
          .unsettled = now.unsettled - before.unsettled,
          .intersections = touches_itself() ? self_contact_.count_intersections(x) : 0};
}

void ContactBridge::begin(const linear::VertexField& x) {
  x_before_ = x;
  solver_.begin(half_thickness_, is_excluded_, x);
}

void ContactBridge::enforce(double dt, fem::State& state) {
  solver_.resolve(dt, x_before_, state.x, state.v);
  x_before_ = state.x;
}

std::size_t ContactBridge::find_gaps(int vertex, const Eigen::Vector3d& x, double reach,
                                     std::array<fem::SurfaceGap, kMaxGaps>& gaps) const {
  // The thickness of excluded vertices is minus infinity, so their gaps are infinite.
  const double thickness = solver_.thickness(static_cast<std::size_t>(vertex));
  std::size_t found = 0;
  const std::span<const contact::PreparedCollider> colliders = solver_.colliders();
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const contact::Proximity near = colliders[i].query(x);
    const double gap = near.distance - thickness;
    if (!(gap < reach)) continue;
    if (found == kMaxGaps) {
      const auto farthest = std::max_element(
          gaps.begin(), gaps.end(), [](const fem::SurfaceGap& a, const fem::SurfaceGap& b) { return a.gap < b.gap; });
      if (gap >= farthest->gap) continue;
      std::move(farthest + 1, gaps.end(), farthest);
      --found;
    }
    gaps[found++] = {static_cast<int>(i), gap, near.normal, colliders[i].friction()};
  }
  return found;
}

}  // namespace kerf::sheet
