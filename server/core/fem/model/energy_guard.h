#pragma once

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {

// Keeps a step from ending with more energy than it began with, if all work on the sheet is known. Gravity and dead
// forces count as potentials. Pins must stand still where they hold. Moving pins, grabs, wind, pressure and moments
// leave the step unguarded, because their work depends on the motion.
//
// Implicit steps that do not resolve the motion gain energy even when solved exactly, because elasticity at large
// rotations is not convex. An implicit Euler step gains up to four times the kinetic energy; many steps gain without
// bound. The guard takes the excess from the velocities. A sheet without pins first loses the part of its velocities
// that deforms it, then its spin. Linear momentum is kept, and so is angular momentum as long as the deformation has
// enough energy.
class EnergyGuard {
 public:
  enum class Verdict {
    kKept,     // no more energy than at the start, or not guarded
    kLimited,  // the velocities were reduced
    // The elastic energy alone exceeds the limit, or without pins its sum with the kinetic energy of the centre of
    // mass. The sheet was stopped, and its centre slowed; shorter steps may help.
    kExceeded,
  };

  // Checks the step from `start` to `end` and limits the velocities of `end`.
  // allowed_gain: -, accepted gain relative to the energy at the start and the work in between. The energy of methods
  // without damping swings about a constant; limiting one side of the swing would damp them.
  // inertia: the clusters with which the step was made, whose kinetic energy counts; null if there are none.
  static Verdict enforce(const Model& model, const Loads& loads, const LocalInertia* inertia, double allowed_gain,
                         const State& start, State& end);
};

}  // namespace kerf::fem
