#pragma once

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {

// Factors of a leapfrog kick under gravity g and mass damping: v' = (1 - lost) v + scale (f / m + g), by the midpoint
// rule.
struct KickFactors {
  double scale = 0.0;  // s
  double lost = 0.0;   // -
};
KickFactors kick_factors(double mass_damping, double duration);

// Predicts the centre of mass and the spin of a sheet, substep by substep. Only gravity and a uniform mass damping may
// act on it. The result is known to round-off in double, whatever precision the sheet itself is stepped with. Damped
// bending slows the spin of a bent sheet (bending_forces.h); the spin is then not corrected.
class FreeFlight {
 public:
  static bool holds(const Model& model, const Loads& loads);

  // Starts from `state`. `inertia` has the clusters that the sheet moves with.
  FreeFlight(const Model& model, const LocalInertia& inertia, const State& state);
  // Advances by one kick and a drift (s).
  void substep(const KickFactors& factors, const Eigen::Vector3d& gravity, double drift);
  // Moves the sheet as a whole so that its centre has the predicted position and velocity. Adds a rigid rotation to its
  // velocities so that it has the predicted angular momentum. Mass on a line gets no rotation about that line.
  void put_right(const Model& model, const LocalInertia& inertia, State& state) const;

 private:
  Eigen::Vector3d x_;     // m
  Eigen::Vector3d v_;     // m/s
  Eigen::Vector3d spin_;  // kg m^2/s, about the centre
};

}  // namespace kerf::fem
