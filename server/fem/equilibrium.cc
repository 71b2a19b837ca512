#include "server/fem/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/fem/bending_forces.h"
#include "server/fem/grab_point.h"
#include "server/fem/membrane.h"

namespace kerf::fem {
namespace {

// Shifts, over the largest eigenvalue of M^-1 K: the first that is tried, how they grow, and below which there is none.
constexpr double kFirstShift = 1e-9;
constexpr double kShiftGrowth = 10.0;
constexpr double kShiftDecay = 0.1;
constexpr double kLeastShift = 1e-13;
constexpr double kLargestShift = 1e3;
constexpr int kMaxBacktracks = 40;
constexpr double kSufficientDecrease = 1e-4;

}  // namespace

EquilibriumSolver::EquilibriumSolver(const EquilibriumOptions& options)
    : options_(options), solver_(make_linear_solver(LinearSolverKind::kDirect, 1)) {}

void EquilibriumSolver::rebuild(const Model& model) {
  matrix_.rebuild(model);
  solver_->analyse(matrix_.blocks());
  for (mesh::VertexField* field : {&force_, &residual_, &rhs_, &step_, &trial_}) field->resize(model.num_vertices());
}

EquilibriumStats EquilibriumSolver::solve(const Model& model, const Loads& loads, const Watch& watch,
                                          mesh::VertexField& x) {
  EquilibriumStats stats;
  for (const Pin& pin : loads.pins) x.col(pin.vertex) = pin.held(pin.target, x.col(pin.vertex));
  stats.residual = evaluate(model, loads, x);
  while (!(stats.residual <= options_.tolerance) && stats.iterations < options_.max_iterations) {
    if (!std::isfinite(stats.residual) || !find_step(model, loads, x, stats)) break;
    ++stats.iterations;
    if (!search_line(model, loads, stats, x)) break;
    if (watch && !watch(stats)) break;
  }
  stats.converged = stats.residual <= options_.tolerance;
  return stats;
}

double EquilibriumSolver::evaluate(const Model& model, const Loads& loads, const mesh::VertexField& x) {
  model.internal_forces(x, force_);
  for (const Grab& grab : loads.grabs) {
    const Eigen::Vector3d pull = grab.stiffness * (grab.target - grab_point(grab, x));
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      force_.col(grab.vertices[k]) += grab.weights[static_cast<Eigen::Index>(k)] * pull;
    }
  }
  const bool has_external = loads.external_forces.cols() > 0;
  double applied = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double m = model.mass()[static_cast<std::size_t>(i)];
    Eigen::Vector3d load = m * loads.gravity;
    if (has_external) load += loads.external_forces.col(i);
    applied += load.squaredNorm();
    residual_.col(i) = force_.col(i) + load;
    if (m == 0.0) residual_.col(i).setZero();
  }
  double reactions = 0.0;
  for (const Pin& pin : loads.pins) {
    const Eigen::Vector3d free = pin.held(Eigen::Vector3d::Zero(), residual_.col(pin.vertex));
    reactions += (residual_.col(pin.vertex) - free).squaredNorm();
    residual_.col(pin.vertex) = free;
  }
  double sum = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i) sum += residual_.col(i).squaredNorm();
  constexpr double kTriangles = 8.0;  // about as many meet at a vertex
  const double rounding = kTriangles * std::numeric_limits<double>::epsilon() * model.membrane_law().trace() *
                          x.cwiseAbs().maxCoeff() * std::sqrt(static_cast<double>(x.cols()));
  return std::sqrt(sum) /
         std::max({std::sqrt(applied + reactions), rounding / options_.tolerance, std::numeric_limits<double>::min()});
}

double EquilibriumSolver::energy(const Model& model, const Loads& loads, const mesh::VertexField& x,
                                 const mesh::VertexField& origin) const {
  double sum = membrane_energy(model.element_blocks(), model.membrane_law(), x) +
               bending_energy(model.bending_rows(), x) + clamp_energy(model.clamp_forces(), x) +
               rest_bending_energy(model.rest_bending(), x);
  const bool has_external = loads.external_forces.cols() > 0;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double m = model.mass()[static_cast<std::size_t>(i)];
    Eigen::Vector3d load = m * loads.gravity;
    if (has_external && m > 0.0) load += loads.external_forces.col(i);
    sum -= load.dot(x.col(i) - origin.col(i));
  }
  for (const Grab& grab : loads.grabs) {
    sum += 0.5 * grab.stiffness * (grab_point(grab, x) - grab.target).squaredNorm();
  }
  return sum;
}

bool EquilibriumSolver::find_step(const Model& model, const Loads& loads, const mesh::VertexField& x,
                                  EquilibriumStats& stats) {
  const double largest = std::max(model.stiffness_bound(), std::numeric_limits<double>::min());
  for (;;) {
    matrix_.set_mass(model, stats.shift);
    matrix_.add_membrane(model, x, {}, 1.0, 1.0, false);
    matrix_.add_bending(model, 1.0);
    for (const Grab& grab : loads.grabs) {
      Grab spring = grab;
      spring.damping = 0.0;
      matrix_.add_grabs({&spring, 1}, 1.0);
    }
    rhs_ = residual_;
    step_.setZero();
    matrix_.constrain(model, loads.pins, 0.0, x, rhs_, step_);
    step_.setZero();
    if (solver_->solve(matrix_.blocks(), rhs_, 1e-6, step_).converged && step_.allFinite()) return true;
    if (stats.shift > kLargestShift * largest) return false;
    stats.shift = std::max(kFirstShift * largest, kShiftGrowth * stats.shift);
  }
}

bool EquilibriumSolver::search_line(const Model& model, const Loads& loads, EquilibriumStats& stats,
                                    mesh::VertexField& x) {
  double slope = 0.0;
  for (Eigen::Index i = 0; i < step_.cols(); ++i) slope += residual_.col(i).dot(step_.col(i));
  const double largest = model.stiffness_bound();
  const double before = energy(model, loads, x, x);
  // Below this, differences of energies are rounding: then the residual has to fall.
  const double rounding = 1e-13 * std::abs(before);
  double scale = 1.0;
  for (int i = 0; i < kMaxBacktracks; ++i, scale *= 0.5) {
    trial_ = x + scale * step_;
    const double after = energy(model, loads, trial_, x);
    if (!(after <= before - kSufficientDecrease * scale * slope + rounding)) continue;
    const double residual = evaluate(model, loads, trial_);
    if (scale * slope <= rounding && !(residual < stats.residual)) continue;
    x = trial_;
    stats.residual = residual;
    // A full step says that the quadratic model holds this far.
    if (i == 0) {
      stats.shift *= kShiftDecay;
      if (stats.shift < kLeastShift * largest) stats.shift = 0.0;
    } else if (i > 2) {
      stats.shift = std::max(kFirstShift * largest, kShiftGrowth * stats.shift);
    }
    return true;
  }
  stats.residual = evaluate(model, loads, x);
  return false;
}

}  // namespace kerf::fem
