#pragma once

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// The complete state of a sheet between steps. No integrator keeps history, so a snapshot of this is enough to continue
// bit for bit.
struct State {
  linear::VertexField x;  // 3 x V, world positions, m
  linear::VertexField v;  // 3 x V, world velocities, m/s
};

// Returns true if every position and velocity is finite.
inline bool is_finite(const State& state) {
  return state.x.allFinite() && state.v.allFinite();
}

}  // namespace kerf::fem
