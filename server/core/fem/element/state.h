#pragma once

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// All that a step changes, and all that it needs to know of the past: no integrator keeps history between steps, so a
// snapshot of this is enough to continue bit for bit.
struct State {
  mesh::VertexField x;  // 3 x V, world positions, m
  mesh::VertexField v;  // 3 x V, world velocities, m/s
};

// Whether every position and velocity is finite.
inline bool is_finite(const State& state) {
  return state.x.allFinite() && state.v.allFinite();
}

}  // namespace kerf::fem
