#include "server/fem/free_flight.h"

#include "server/fem/follower_loads.h"

namespace kerf::fem {
namespace {

Eigen::Vector3d velocity_of_centre(const Model& model, const State& state) {
  return model.momentum(state).linear / model.total_mass();
}

}  // namespace

KickFactors kick_factors(double mass_damping, double duration) {
  const double half = 0.5 * mass_damping * duration;
  return {duration / (1.0 + half), 2.0 * half / (1.0 + half)};
}

bool FreeFlight::holds(const Model& model, const Loads& loads) {
  const bool is_held = !loads.pins.empty() || !loads.grabs.empty() || !model.clamp_forces().forces.empty();
  const bool is_pushed = loads.external_forces.cols() > 0 || loads.wind.air_density > 0.0 || has_follower_loads(loads);
  return !is_held && !is_pushed && model.materials().has_one_mass_damping() && model.total_mass() > 0.0;
}

FreeFlight::FreeFlight(const Model& model, const State& state)
    : x_(model.centre_of_mass(state.x)), v_(velocity_of_centre(model, state)) {}

void FreeFlight::substep(const KickFactors& factors, const Eigen::Vector3d& gravity, double drift) {
  v_ += factors.scale * gravity - factors.lost * v_;
  x_ += drift * v_;
}

void FreeFlight::centre(const Model& model, State& state) const {
  const Eigen::Vector3d dx = x_ - model.centre_of_mass(state.x);
  const Eigen::Vector3d dv = v_ - velocity_of_centre(model, state);
  for (int v = 0; v < model.num_vertices(); ++v) {
    if (model.mass()[static_cast<std::size_t>(v)] == 0.0) continue;
    state.x.col(v) += dx;
    state.v.col(v) += dv;
  }
}

}  // namespace kerf::fem
