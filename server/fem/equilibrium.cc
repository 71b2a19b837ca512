#include "server/fem/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/fem/bending_forces.h"
#include "server/fem/follower_loads.h"
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
constexpr double kLinearTolerance = 1e-6;
constexpr int kMaxBacktracks = 40;
constexpr double kSufficientDecrease = 1e-4;
constexpr double kDiscernible = 100.0;  // decrease of the energy, over what rounding leaves of it
constexpr int kMaxBlindSteps = 10;      // without a better residual

}  // namespace

EquilibriumSolver::EquilibriumSolver(const EquilibriumOptions& options) : options_(options) {}

void EquilibriumSolver::rebuild(const Model& model) {
  matrix_.rebuild(model);
  skew_ = {};
  solver_.analyse(matrix_.blocks());
  for (mesh::VertexField* field : {&force_, &residual_, &rhs_, &step_, &trial_, &best_})
    field->resize(model.num_vertices());
}

EquilibriumStats EquilibriumSolver::solve(const Model& model, const Loads& loads, const Watch& watch,
                                          mesh::VertexField& x) {
  EquilibriumStats stats;
  for (const Pin& pin : loads.pins) x.col(pin.vertex) = pin.held(pin.target, x.col(pin.vertex));
  stats.residual = evaluate(model, loads, x);
  best_ = x;
  double best = stats.residual;
  int since_best = 0;
  while (!(stats.residual <= options_.tolerance) && stats.iterations < options_.max_iterations) {
    if (!std::isfinite(stats.residual) || !find_step(model, loads, x, stats)) break;
    ++stats.iterations;
    const Progress progress = search_line(model, loads, stats, x);
    if (progress == Progress::kNone) break;
    if (stats.residual < best) {
      best = stats.residual;
      best_ = x;
      since_best = 0;
    } else if (progress == Progress::kBlind && ++since_best == kMaxBlindSteps) {
      break;
    }
    if (watch && !watch(stats)) break;
  }
  if (!(stats.residual <= best)) {
    x = best_;
    stats.residual = evaluate(model, loads, x);
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
  residual_.setZero();
  add_follower_forces(model.element_blocks(), loads, x, residual_);
  double applied = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double m = model.mass()[static_cast<std::size_t>(i)];
    Eigen::Vector3d load = m * loads.gravity;
    if (has_external) load += loads.external_forces.col(i);
    load += residual_.col(i);
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
  return sum - follower_work(model.element_blocks(), loads, origin, x);
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
    matrix_.add_follower_loads(model, loads, x, 1.0, MatrixPart::kSymmetric);
    rhs_ = residual_;
    step_.setZero();
    matrix_.constrain(model, loads.pins, 0.0, x, rhs_, step_);
    step_.setZero();
    if (solver_.solve(matrix_.blocks(), rhs_, kLinearTolerance, step_).converged && step_.allFinite()) {
      if (has_follower_loads(loads)) correct_step(model, loads, x);
      return true;
    }
    if (stats.shift > kLargestShift * largest) return false;
    stats.shift = std::max(kFirstShift * largest, kShiftGrowth * stats.shift);
  }
}

// A step with the skew part has as good a slope as one without: it adds nothing to step.(K + N) step.
void EquilibriumSolver::correct_step(const Model& model, const Loads& loads, const mesh::VertexField& x) {
  if (skew_.blocks().num_rows() != model.num_vertices()) skew_.rebuild(model);
  skew_.blocks().set_zero();
  skew_.add_follower_loads(model, loads, x, 1.0, MatrixPart::kSkew);
  skew_.clear_pinned(loads.pins);
  correction_.solve(solver_, matrix_.blocks(), skew_.blocks(), rhs_, kLinearTolerance, step_);
}

EquilibriumSolver::Progress EquilibriumSolver::search_line(const Model& model, const Loads& loads,
                                                           EquilibriumStats& stats, mesh::VertexField& x) {
  double slope = 0.0;
  for (Eigen::Index i = 0; i < step_.cols(); ++i) slope += residual_.col(i).dot(step_.col(i));
  const double largest = model.stiffness_bound();
  const double before = energy(model, loads, x, x);
  // What rounding leaves of it: strains are differences of numbers near 1.
  const double area = model.total_mass() / (model.material().density * model.material().thickness);
  const double membrane = membrane_energy(model.element_blocks(), model.membrane_law(), x);
  const double rounding = std::numeric_limits<double>::epsilon() *
                          (8.0 * std::sqrt(2.0 * membrane * model.membrane_law().trace() * area) + std::abs(before));
  // Where no difference of energies can tell, Newton's step is as good as any.
  if (slope <= kDiscernible * rounding) {
    x += step_;
    stats.residual = evaluate(model, loads, x);
    stats.shift = 0.0;
    return Progress::kBlind;
  }
  double scale = 1.0;
  for (int i = 0; i < kMaxBacktracks; ++i, scale *= 0.5) {
    trial_ = x + scale * step_;
    const double after = energy(model, loads, trial_, x);
    if (!(after <= before - kSufficientDecrease * scale * slope + rounding)) continue;
    x = trial_;
    stats.residual = evaluate(model, loads, x);
    // A full step says that the quadratic model holds this far.
    if (i == 0) {
      stats.shift *= kShiftDecay;
      if (stats.shift < kLeastShift * largest) stats.shift = 0.0;
    } else if (i > 2) {
      stats.shift = std::max(kFirstShift * largest, kShiftGrowth * stats.shift);
    }
    return Progress::kDescended;
  }
  return Progress::kNone;
}

}  // namespace kerf::fem
