#include "server/core/fem/statics/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/core/fem/element/angle_bending.h"
#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/element/grab_point.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/element/membrane_tangent.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {
namespace {

// -, shifts relative to the largest eigenvalue of M^-1 K. kLeastShift is the one below which a shift becomes 0, and
// kLargestExactShift the largest with the exact tangent.
constexpr double kFirstShift = 1e-9;
constexpr double kShiftGrowth = 10.0;
constexpr double kLargestExactShift = 1e-5;
constexpr double kShiftDecay = 0.1;
constexpr double kLeastShift = 1e-13;
constexpr double kRounding = 1e-12;  // rounding of the eigenvalues of free motions, relative to the largest eigenvalue
                                     // of M^-1 K
constexpr double kLargestShift = 1e3;
constexpr double kLinearTolerance = 1e-6;
constexpr int kMaxWatchdogSteps = 6;    // steps
constexpr double kWatchdogDecay = 0.5;  // largest ratio of the rises of the energy in consecutive steps
// -, decrease of the energy over the slope from which on a step is lengthened. A full step has 0.5 if the energy is
// quadratic.
constexpr double kLinearDecrease = 0.9;
constexpr int kMaxLengthenings = 20;
constexpr int kMaxLineHalvings = 40;
constexpr double kSufficientDecrease = 1e-4;
constexpr double kDiscernible = 100.0;    // least slope over the rounding error of the energy at which energies can be
                                          // compared
constexpr int kMaxNonMonotoneSteps = 10;  // consecutive steps without a better residual

}  // namespace

EquilibriumSolver::EquilibriumSolver(const EquilibriumOptions& options) : options_(options) {}

void EquilibriumSolver::rebuild(const Model& model) {
  matrix_.rebuild(model);
  skew_ = {};
  solver_.analyse(matrix_.blocks());
  moments_.clear();
  stress_.resize(model.element_blocks().size() * kLanes);
  for (linear::VertexField* field : {&force_, &residual_, &rhs_, &step_, &trial_, &watchdog_x_, &best_})
    field->resize(model.num_vertices());
}

EquilibriumStats EquilibriumSolver::solve(const Model& model, const Loads& loads, const EquilibriumWatch& watch,
                                          linear::VertexField& x) {
  EquilibriumStats stats;
  for (const Pin& pin : loads.pins) x.col(pin.vertex) = pin.held(pin.target, x.col(pin.vertex));
  stats.residual = evaluate(model, loads, x);
  best_ = x;
  double best = stats.residual;
  int since_best = 0;
  step_.setZero();
  predict(model, x);
  const double first_shift = kFirstShift * model.stiffness_bound().value();
  used_shift_ = 0.0;
  projects_ = false;
  // A load hidden by rounding of the forces may still move the sheet; one step is enough.
  bool is_hidden = stats.residual <= options_.tolerance && unbalanced_ > options_.tolerance;
  while ((is_hidden || !(stats.residual <= options_.tolerance)) && stats.iterations < options_.max_iterations) {
    if (!std::isfinite(stats.residual)) break;
    Progress progress = try_watchdog_steps(model, loads, stats, x);
    if (progress == Progress::kNone) {
      if (stats.iterations == options_.max_iterations || !find_step(model, loads, x, false, stats)) break;
      ++stats.iterations;
      progress = search_line(model, loads, stats, x);
      predict(model, x);
    }
    if (progress == Progress::kNone) break;
    if (stats.residual < best || progress == Progress::kDescended ||
        (is_hidden && stats.residual <= options_.tolerance)) {
      best = stats.residual;
      best_ = x;
      since_best = 0;
    } else if (progress == Progress::kNonMonotone && ++since_best == kMaxNonMonotoneSteps) {
      break;
    }
    is_hidden = false;
    if (watch && !watch(stats)) break;
  }
  if (!(stats.residual <= best)) {
    x = best_;
    stats.residual = evaluate(model, loads, x);
  }
  stats.converged = stats.residual <= options_.tolerance;
  stats.shift = used_shift_;
  // The last step shows whether its start was stable, so the end is tested separately.
  if (stats.converged) stats.shift = is_stable(model, loads, x) ? 0.0 : std::max(used_shift_, first_shift);
  return stats;
}

void EquilibriumSolver::predict(const Model& model, const linear::VertexField& x) {
  predict_stress(model.element_blocks(), model.materials(), x, step_, stress_);
  if (model.bending().angles() != nullptr) moments_ = model.bending().angles()->predicted_moments(x, step_);
}

double EquilibriumSolver::evaluate(const Model& model, const Loads& loads, const linear::VertexField& x) {
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
  constexpr double kTriangles = 8.0;  // approximate number of triangles at a vertex
  const double rounding = kTriangles * std::numeric_limits<double>::epsilon() *
                          model.materials().largest_membrane_trace() * x.cwiseAbs().maxCoeff() *
                          std::sqrt(static_cast<double>(x.cols()));
  const double known = std::sqrt(applied + reactions);
  unbalanced_ = known > 0.0 ? std::sqrt(sum) / known : 0.0;
  return std::sqrt(sum) / std::max({known, rounding / options_.tolerance, std::numeric_limits<double>::min()});
}

double EquilibriumSolver::energy(const Model& model, const Loads& loads, const linear::VertexField& x,
                                 const linear::VertexField& origin) const {
  double sum =
      membrane_energy(model.element_blocks(), model.materials(), x) + model.bending().energy(model.element_blocks(), x);
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

double EquilibriumSolver::rounding(const Model& model, const linear::VertexField& x, double energy) {
  // Strains are differences of numbers near 1.
  const double membrane = membrane_energy(model.element_blocks(), model.materials(), x);
  return std::numeric_limits<double>::epsilon() *
         (8.0 * std::sqrt(2.0 * membrane * model.materials().largest_membrane_trace() * model.elements().area()) +
          std::abs(energy));
}

void EquilibriumSolver::assemble(const Model& model, const Loads& loads, const linear::VertexField& x, bool predicted,
                                 bool project, double shift) {
  const std::span<const Eigen::Vector3d> stress(stress_);
  matrix_.set_mass(model, shift);
  matrix_.add_membrane(model, x, predicted ? stress : stress.first(0), {}, 1.0, project);
  matrix_.add_bending_at(model, x, std::span<const double>(moments_).first(predicted ? moments_.size() : 0), project);
  for (const Grab& grab : loads.grabs) {
    Grab spring = grab;
    spring.damping = 0.0;
    matrix_.add_grabs({&spring, 1}, 1.0);
  }
  if (!project) matrix_.add_follower_loads(model, loads, x, 1.0, MatrixPart::kSymmetric);
  rhs_ = residual_;
  step_.setZero();
  matrix_.constrain(model, loads.pins, 0.0, x, rhs_, step_);
  step_.setZero();
}

bool EquilibriumSolver::find_step(const Model& model, const Loads& loads, const linear::VertexField& x, bool predicted,
                                  EquilibriumStats& stats) {
  const double largest = std::max(model.stiffness_bound().value(), std::numeric_limits<double>::min());
  const double start = stats.shift;
  const auto solve = [&] {
    return solver_.solve(matrix_.blocks(), rhs_, kLinearTolerance, step_).converged && step_.allFinite();
  };
  // Adds as much mass as buckling needs. Slack or far too short sheets would need more than is useful.
  for (;;) {
    assemble(model, loads, x, predicted, false, stats.shift);
    used_shift_ = stats.shift;
    if (solve()) {
      if (has_follower_loads(loads)) correct_step(model, loads, x);
      projects_ = false;
      return true;
    }
    const double next = std::max(kFirstShift * largest, kShiftGrowth * stats.shift);
    if (projects_ || next > kLargestExactShift * largest) break;
    stats.shift = next;
  }
  projects_ = true;
  stats.shift = std::max(start, kFirstShift * largest);
  for (; stats.shift <= kLargestShift * largest; stats.shift *= kShiftGrowth) {
    assemble(model, loads, x, predicted, true, stats.shift);
    used_shift_ = stats.shift;
    if (solve()) return true;
  }
  return false;
}

bool EquilibriumSolver::is_stable(const Model& model, const Loads& loads, const linear::VertexField& x) {
  assemble(model, loads, x, false, false, kRounding * model.stiffness_bound().value());
  return solver_.solve(matrix_.blocks(), rhs_, kLinearTolerance, step_).iterations > 0;
}

// A step with the skew part has as good a slope as one without: it adds nothing to step.(K + N) step.
void EquilibriumSolver::correct_step(const Model& model, const Loads& loads, const linear::VertexField& x) {
  if (skew_.blocks().num_rows() != model.num_vertices()) skew_.rebuild(model);
  skew_.blocks().set_zero();
  skew_.add_follower_loads(model, loads, x, 1.0, MatrixPart::kSkew);
  skew_.clear_pinned(loads.pins);
  correction_.solve(solver_, matrix_.blocks(), skew_.blocks(), rhs_, kLinearTolerance, step_);
}

void EquilibriumSolver::add_proximal_term(const Model& model, const linear::VertexField& x) {
  for (Eigen::Index v = 0; v < x.cols(); ++v) {
    residual_.col(v) -= used_shift_ * model.mass()[static_cast<std::size_t>(v)] * (watchdog_x_.col(v) - x.col(v));
  }
}

EquilibriumSolver::Progress EquilibriumSolver::try_watchdog_steps(const Model& model, const Loads& loads,
                                                                  EquilibriumStats& stats, linear::VertexField& x) {
  const double shift = stats.shift;
  const double residual = stats.residual;
  const double before = energy(model, loads, x, x);
  watchdog_x_ = x;
  double slope = 0.0;
  double last_rise = 0.0;
  for (int i = 0; i < kMaxWatchdogSteps && stats.iterations < options_.max_iterations; ++i) {
    if (i > 0) add_proximal_term(model, x);
    if (!find_step(model, loads, watchdog_x_, true, stats)) break;
    ++stats.iterations;
    if (i == 0) {
      slope = residual_.cwiseProduct(step_).sum();
      if (slope <= kDiscernible * rounding(model, x, before)) {
        predict(model, x);
        x += step_;
        stats.residual = evaluate(model, loads, x);
        stats.shift = 0.0;
        return Progress::kNonMonotone;
      }
    }
    predict(model, watchdog_x_);
    watchdog_x_ += step_;
    stats.residual = evaluate(model, loads, watchdog_x_);
    if (!std::isfinite(stats.residual)) break;
    const double rise = energy(model, loads, watchdog_x_, x) - before;
    if (rise <= -kSufficientDecrease * slope) {
      if (i == 0 && rise <= -kLinearDecrease * slope) lengthen_step(model, loads, before + rise, x, stats);
      x = watchdog_x_;
      stats.shift *= kShiftDecay;
      if (stats.shift < kLeastShift * model.stiffness_bound().value()) stats.shift = 0.0;
      return Progress::kDescended;
    }
    // In a sequence that succeeds, each step removes nearly all false stretch of the previous step, and the rise of the
    // energy with it.
    if (i > 0 && !(rise <= kWatchdogDecay * last_rise)) break;
    last_rise = rise;
  }
  stats.shift = shift;
  stats.residual = residual;
  evaluate(model, loads, x);
  return Progress::kNone;
}

void EquilibriumSolver::lengthen_step(const Model& model, const Loads& loads, double reached,
                                      const linear::VertexField& x, EquilibriumStats& stats) {
  for (int i = 0; i < kMaxLengthenings; ++i) {
    trial_ = x + 2.0 * step_;
    const double after = energy(model, loads, trial_, x);
    if (!(after < reached)) break;
    reached = after;
    step_ *= 2.0;
    watchdog_x_ = trial_;
  }
  predict(model, x);
  stats.residual = evaluate(model, loads, watchdog_x_);
}

EquilibriumSolver::Progress EquilibriumSolver::search_line(const Model& model, const Loads& loads,
                                                           EquilibriumStats& stats, linear::VertexField& x) {
  double slope = 0.0;
  for (Eigen::Index i = 0; i < step_.cols(); ++i) slope += residual_.col(i).dot(step_.col(i));
  const double largest = model.stiffness_bound().value();
  const double before = energy(model, loads, x, x);
  const double noise = rounding(model, x, before);
  // If rounding hides differences of energies, Newton's step is as good as any.
  if (slope <= kDiscernible * noise) {
    x += step_;
    stats.residual = evaluate(model, loads, x);
    stats.shift = 0.0;
    return Progress::kNonMonotone;
  }
  double scale = 1.0;
  for (int i = 0; i < kMaxLineHalvings; ++i, scale *= 0.5) {
    trial_ = x + scale * step_;
    const double after = energy(model, loads, trial_, x);
    if (!(after <= before - kSufficientDecrease * scale * slope + noise)) continue;
    x = trial_;
    stats.residual = evaluate(model, loads, x);
    // A full step shows that the quadratic model holds this far.
    if (i == 0) {
      stats.shift *= kShiftDecay;
      if (stats.shift < kLeastShift * largest) stats.shift = 0.0;
    } else if (i > 2) {
      stats.shift = std::max(kFirstShift * largest, stats.shift / scale);
    }
    return Progress::kDescended;
  }
  return Progress::kNone;
}

}  // namespace kerf::fem
