#pragma once

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {

// Keeps a step from ending with more energy than it began with, where that can be told: nothing that acts has a work
// that only the motion decides. Gravity and dead forces are counted as potentials, pins must stand still where they
// hold; moving pins, grabs, wind, pressure and moments leave the step unguarded.
//
// Implicit steps that do not resolve the motion gain energy even when solved exactly, elasticity at large rotations not
// being convex (at most to four times the kinetic energy for implicit Euler, unboundedly after many steps). What is
// over is taken from the velocities: of a sheet without pins first from those that deform it, then from its spin, so
// that linear momentum is kept, and angular momentum as long as deformation has enough.
class EnergyGuard {
 public:
  enum class Verdict {
    kKept,     // no more than at the start, or not guarded
    kLimited,  // the velocities were changed
    // The elastic energy alone, or with that of a free sheet's centre, is more: shorter steps may do. The sheet was
    // stopped, its centre slowed.
    kExceeded,
  };

  // allowed_gain: -, that is let pass, of the energy at the start and of the work between. Methods that damp nothing
  // swing about the energy that they keep; cut off on one side only, they would damp.
  // inertia: of the scheme that made the step, whose kinetic energy counts; may be null.
  static Verdict enforce(const Model& model, const Loads& loads, const LocalInertia* inertia, double allowed_gain,
                         const State& start, State& end);
};

}  // namespace kerf::fem
