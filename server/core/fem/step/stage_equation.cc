#include "server/core/fem/step/stage_equation.h"

#include <cmath>

#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/element/grab_point.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/majorized_membrane.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {

void StageResidual::resize(int num_vertices) {
  for (linear::VertexField* field : {&force_, &velocity_, &damped_}) field->resize(num_vertices);
}

double StageResidual::evaluate(const StageProblem& problem, const linear::VertexField& x,
                               linear::VertexField& residual) {
  const Stage& stage = problem.stage;
  const Model& model = problem.model;
  velocity_ = (x - stage.base.x) / stage.d;
  force_ = problem.constant_force;
  if (problem.is_majorized) {
    add_majorized_forces(model.element_blocks(), model.materials(), x, force_);
  } else {
    add_membrane_forces(model.element_blocks(), model.materials(), problem.beta, x, velocity_, force_);
  }
  model.bending().add_forces(model.element_blocks(), x, velocity_, problem.beta, damped_, force_);
  add_follower_forces(model.element_blocks(), problem.loads, x, force_);
  add_grab_forces(problem, x);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double m = model.mass()[static_cast<std::size_t>(i)];
    const double inertia = 1.0 + stage.d * model.masses().damping(static_cast<int>(i));
    const Eigen::Vector3d impulse =
        stage.base.v.col(i) - (inertia / stage.d) * (x.col(i) - stage.base.x.col(i)) + stage.d * problem.loads.gravity;
    residual.col(i) = m * stage.d * impulse + stage.d * stage.d * force_.col(i);
    if (m == 0.0) residual.col(i).setZero();
  }
  double sum = 0.0;
  for (const Pin& pin : problem.loads.pins) {
    residual.col(pin.vertex) = pin.held(Eigen::Vector3d::Zero(), residual.col(pin.vertex));
  }
  for (Eigen::Index i = 0; i < x.cols(); ++i) sum += residual.col(i).squaredNorm();
  return std::sqrt(sum);
}

void StageResidual::add_grab_forces(const StageProblem& problem, const linear::VertexField& x) {
  for (const Grab& grab : problem.loads.grabs) {
    const Eigen::Vector3d target = grab.target - problem.stage.time_left * grab.velocity;
    const Eigen::Vector3d f =
        grab.stiffness * (target - grab_point(grab, x)) + grab.damping * (grab.velocity - grab_point(grab, velocity_));
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      force_.col(grab.vertices[k]) += grab.weights[static_cast<Eigen::Index>(k)] * f;
    }
  }
}

double incremental_potential(const StageProblem& problem, double contact, const linear::VertexField& x,
                             const linear::VertexField& origin) {
  const Stage& stage = problem.stage;
  const Model& model = problem.model;
  const double d = stage.d;
  double potential = membrane_energy(model.element_blocks(), model.materials(), x);
  if (model.materials().has_bending()) potential += model.bending().energy(model.element_blocks(), x);
  double kinetic = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double m = model.mass()[static_cast<std::size_t>(i)];
    const double inertia = 1.0 + d * model.masses().damping(static_cast<int>(i));
    const Eigen::Vector3d dx = x.col(i) - stage.base.x.col(i);
    kinetic += m * (0.5 * inertia * dx.squaredNorm() - d * stage.base.v.col(i).dot(dx));
    potential -= (m * problem.loads.gravity + problem.constant_force.col(i)).dot(dx);
  }
  for (const Grab& grab : problem.loads.grabs) {
    const Eigen::Vector3d target = grab.target - stage.time_left * grab.velocity;
    const Eigen::Vector3d p = grab_point(grab, x);
    const Eigen::Vector3d slip = (p - grab_point(grab, stage.base.x)) / d - grab.velocity;
    potential += 0.5 * grab.stiffness * (p - target).squaredNorm() + 0.5 * grab.damping * d * slip.squaredNorm();
  }
  potential += contact;
  if (has_follower_loads(problem.loads)) {
    potential -= follower_work(model.element_blocks(), problem.loads, origin, x);
  }
  return kinetic + d * d * potential;
}

void restore_momentum(const StageProblem& problem, linear::VertexField& x) {
  const Stage& stage = problem.stage;
  const Model& model = problem.model;
  Eigen::Vector3d missing = stage.d * stage.momentum;
  missing += stage.d * stage.d * follower_resultant(model.element_blocks(), problem.loads, x);
  double mass = 0.0;
  double inert_mass = 0.0;  // kg, masses times the inertia factor of each
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double m = model.mass()[static_cast<std::size_t>(i)];
    const double inertia = 1.0 + stage.d * model.masses().damping(static_cast<int>(i));
    mass += m;
    inert_mass += m * inertia;
    missing -= m * inertia * (x.col(i) - stage.base.x.col(i));
    missing += stage.d * stage.d * (m * problem.loads.gravity + problem.constant_force.col(i));
  }
  if (!(mass > 0.0)) return;
  if (model.materials().has_one_mass_damping()) inert_mass = mass * (1.0 + stage.d * model.masses().damping(0));
  const Eigen::Vector3d shift = missing / inert_mass;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    if (model.mass()[static_cast<std::size_t>(i)] > 0.0) x.col(i) += shift;
  }
}

}  // namespace kerf::fem
