#pragma once

#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

class ContactConstraint;

// One implicit stage: x = base.x + d v with M v = M base.v + d (f(x, v) + constant force + M g - alpha M v), hence
//   M (1 + d alpha) (x - base.x) - d M base.v - d^2 (f(x, v) + constant force + M g) = 0.
// Implicit Euler, the trapezoidal rule and BDF2 are stages with their own base and d.
struct Stage {
  State base;
  // kg m/s, total momentum of base.v. Internal forces are left out of it, because only their rounding has a resultant.
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double d = 0.0;                 // s, > 0
  linear::VertexField ballistic;  // m, end of the stage under gravity alone, where the search begins
  double time_left = 0.0;         // s, from the end of the stage to the end of the step, for moving pins and grabs
  // True if the last StageSolver::solve() was of the previous stage of the same step. The first iteration then uses the
  // stress that it predicted. The stress at its end may contain false stretch if it stopped after a few linear steps.
  bool continues = false;
  bool may_repair = true;  // false: the stage fails if the fast iteration fails
  const ContactConstraint* contact = nullptr;
  const linear::VertexField* start = nullptr;  // m, positions when the substep began; required with contact
};

// Data of one solve of a stage.
struct StageProblem {
  const Model& model;
  const Loads& loads;
  const linear::VertexField& constant_force;  // N
  const Stage& stage;
  std::span<const double> beta;       // stiffness damping, see damping_of; none in a repair
  bool is_majorized = false;          // replaces the membrane by the quadratics that bound its energy at the given x,
                                      // see MajorizedTriangle
  bool has_follower_tangent = false;  // the matrix includes the tangent of follower loads
};

// Evaluates the residual of a stage: minus the left side of the equation at Stage.
class StageResidual {
 public:
  void resize(int num_vertices);
  // Sets `residual` (3 x V, kg m) at x (3 x V, m), zero at pins, without contact forces. Returns its Euclidean norm.
  double evaluate(const StageProblem& problem, const linear::VertexField& x, linear::VertexField& residual);

 private:
  void add_grab_forces(const StageProblem& problem, const linear::VertexField& x);

  linear::VertexField force_, velocity_, damped_;  // 3 x V, scratch
};

// Returns the incremental potential, kg m^2, whose negative gradient is the residual if beta is 0. `contact` is the
// potential of contacts at `x`, J. Follower loads have no potential. Minus their work from `origin` to `x` takes its
// place, so only values with the same origin can be compared.
double incremental_potential(const StageProblem& problem, double contact, const linear::VertexField& x,
                             const linear::VertexField& origin);

// Translates a free sheet so that its residual has no resultant. Internal forces have none, so linear momentum is
// conserved to round-off however loosely the stage was solved.
void restore_momentum(const StageProblem& problem, linear::VertexField& x);

}  // namespace kerf::fem
