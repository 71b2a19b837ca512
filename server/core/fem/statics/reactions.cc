#include "server/core/fem/statics/reactions.h"

#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/element/grab_point.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/element/wind_drag.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {
namespace {

// Adds all loads at x to f, except wind and forces that depend on velocities.
void add_loads(const Model& model, const Loads& loads, const linear::VertexField& x, linear::VertexField& f) {
  if (loads.external_forces.cols() > 0) f += loads.external_forces;
  add_follower_forces(model.element_blocks(), loads, x, f);
  for (const Grab& grab : loads.grabs) {
    const Eigen::Vector3d pull = grab.stiffness * (grab.target - grab_point(grab, x));
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      f.col(grab.vertices[k]) += grab.weights[static_cast<Eigen::Index>(k)] * pull;
    }
  }
  for (Eigen::Index i = 0; i < f.cols(); ++i) f.col(i) += model.mass()[static_cast<std::size_t>(i)] * loads.gravity;
}

// Replaces f, the sum of all forces on the vertices except those of pins, by the reactions.
void turn_into_reactions(const Loads& loads, linear::VertexField& f) {
  linear::VertexField reactions = Eigen::Matrix3Xd::Zero(3, f.cols());
  for (const Pin& pin : loads.pins) reactions.col(pin.vertex) = pin.held(-f.col(pin.vertex), Eigen::Vector3d::Zero());
  f = reactions;
}

}  // namespace

void find_reactions(const Model& model, const Loads& loads, const linear::VertexField& x,
                    linear::VertexField& reactions) {
  reactions.resize(model.num_vertices());
  model.internal_forces(x, reactions);
  add_loads(model, loads, x, reactions);
  turn_into_reactions(loads, reactions);
}

void find_reactions(const Model& model, const Loads& loads, const State& state, const linear::VertexField& acceleration,
                    linear::VertexField& reactions) {
  const std::span<const double> beta = model.materials().stiffness_damping();
  linear::VertexField& f = reactions;
  f = Eigen::Matrix3Xd::Zero(3, model.num_vertices());
  add_membrane_forces(model.element_blocks(), model.materials(), beta, state.x, state.v, f);
  linear::VertexField damped = Eigen::Matrix3Xd::Zero(3, model.num_vertices());
  model.bending().add_forces(model.element_blocks(), state.x, state.v, beta, damped, f);
  add_loads(model, loads, state.x, f);
  add_wind_drag(model.element_blocks(), model.materials(), loads.wind, 0.0, state, f);
  for (const Grab& grab : loads.grabs) {
    const Eigen::Vector3d pull = grab.damping * (grab.velocity - grab_point(grab, state.v));
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      f.col(grab.vertices[k]) += grab.weights[static_cast<Eigen::Index>(k)] * pull;
    }
  }
  for (Eigen::Index i = 0; i < f.cols(); ++i) {
    const double m = model.mass()[static_cast<std::size_t>(i)];
    f.col(i) -= m * (acceleration.col(i) + model.masses().damping(static_cast<int>(i)) * state.v.col(i));
  }
  turn_into_reactions(loads, f);
}

}  // namespace kerf::fem
