#pragma once

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {

// What a leapfrog kick does under gravity g and mass damping: v' = (1 - lost) v + scale (f / m + g). Midpoint rule.
struct KickFactors {
  double scale = 0.0;  // s
  double lost = 0.0;   // -
};
KickFactors kick_factors(double mass_damping, double duration);

// Where the centre of mass of a sheet goes on which nothing acts but gravity and a mass damping that is the same
// everywhere, and what is left of its spin, substep for substep: known to round-off in double, whatever precision the
// sheet itself is moved with. Damped bending brakes the spin of a sheet that is bent (bending_forces.h): there it is
// left as it is.
class FreeFlight {
 public:
  static bool holds(const Model& model, const Loads& loads);

  // With the inertia that the sheet is moved by.
  FreeFlight(const Model& model, const LocalInertia& inertia, const State& state);
  // One kick, and a drift (s).
  void substep(const KickFactors& factors, const Eigen::Vector3d& gravity, double drift);
  // Moves the sheet as a whole, so that its centre is where it should be, and as fast, and adds a rigid rotation to its
  // velocities, so that it has the angular momentum that it should have, but none about a line that all its mass is on.
  void put_right(const Model& model, const LocalInertia& inertia, State& state) const;

 private:
  Eigen::Vector3d x_;     // m
  Eigen::Vector3d v_;     // m/s
  Eigen::Vector3d spin_;  // kg m^2/s, about the centre
};

}  // namespace kerf::fem
