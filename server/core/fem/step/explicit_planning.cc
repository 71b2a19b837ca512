#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/explicit_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

// Members of ExplicitIntegrator that derive plans from a model before any step: the stable step, damping, clusters and
// the intervals of bending.
namespace kerf::fem {
namespace {

constexpr double kLongestKick = 1.4;  // rad, largest n h omega_b, see bending_interval()

// Returns the speed of stretching waves, m/s.
double wave_speed(const MaterialLaw& law) {
  return std::sqrt(law.membrane.diagonal().maxCoeff() / law.surface_density);
}

// Calls visit(law) for each material of any triangle.
template <typename Visit>
void for_each_material(const Model& model, const Visit& visit) {
  const MaterialTable& materials = model.materials();
  if (materials.has_one()) return visit(materials[0]);
  std::array<bool, kMaxMaterials> has{};
  for (const ElementBlock& block : model.element_blocks()) {
    for (std::size_t l = 0; l < kLanes; ++l) has[block.material[l]] = has[block.material[l]] || block.area[l] > 0.0;
  }
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (has[i]) visit(materials[i]);
  }
}

// Returns the wave speed in the stiffest material of any triangle.
double fastest_wave(const Model& model) {
  double fastest = 0.0;
  for_each_material(model, [&](const MaterialLaw& law) { fastest = std::max(fastest, wave_speed(law)); });
  return fastest;
}

// Returns the largest damping time of all materials, s; 0 if there is none.
double longest(const std::vector<double>& beta) {
  return beta.empty() ? 0.0 : *std::max_element(beta.begin(), beta.end());
}

}  // namespace

ExplicitIntegrator::Reference ExplicitIntegrator::reference(const Model& model) {
  // -, absolute row sums at an inner vertex of a grid of squares with parallel diagonals.
  constexpr double kMembraneRow = 8.0;  // of L, see LocalInertia
  constexpr double kBendingRow = 64.0;  // of Q, in units of D / length^2
  const double edge = model.masses().typical_edge_length();
  Reference fastest;
  if (!(edge > 0.0)) return fastest;
  for_each_material(model, [&](const MaterialLaw& law) {
    const double mass = law.surface_density * edge * edge;
    const double bending = kBendingRow * law.bending.diagonal().maxCoeff() / (edge * edge);
    fastest.bending_omega = std::max(fastest.bending_omega, std::sqrt(bending / mass));
    fastest.omega = std::max(fastest.omega, std::sqrt((kMembraneRow * law.curvature_bound + bending) / mass));
  });
  return fastest;
}

void ExplicitIntegrator::plan(const Model& model, bool follows) {
  fastest_wave_ = fastest_wave(model);
  omega_ = std::sqrt(model.stiffness_bound().value());
  bending_omega_ = std::sqrt(model.stiffness_bound().bending());
  set_damping(model, options_.highest_mode_damping);
  critical_step_ = critical_step(1.0);
  plain_step_ = cfl() * critical_step_;
  const std::optional<InertiaTerms> terms = inertia_terms(model);
  if (!follows) inertia_.reserve(static_cast<std::size_t>(model.num_vertices()));
  follows = follows && inertia_.is_active();
  inertia_.set_active(terms.has_value());
  if (terms) follows ? inertia_.follow(model, *terms) : inertia_.rebuild(model, *terms);
  explanation_ = "explicit: velocity Verlet, stable step " + std::to_string(critical_step_ * 1e6) + " us";
  if (!inertia_.empty()) {
    explanation_ += ", " + std::to_string(inertia_.clusters().size()) + " clusters of " +
                    std::to_string(inertia_.num_vertices()) + " vertices with local inertia, the largest of " +
                    std::to_string(inertia_.largest());
  }
}

std::optional<InertiaTerms> ExplicitIntegrator::inertia_terms(const Model& model) {
  // -, highest frequency that a step resolves, over that of the sheet as built; clusters take over beyond it. With a
  // smaller ratio steps are longer and err more, above all once cuts cross: see tests/bench/notes/random-cuts.md.
  constexpr double kNominal = 2.3;
  // -, the same ratio for curved rest shapes. Their cuts would make larger clusters, because tiny triangles lie at the
  // sharp bends between facets.
  constexpr double kCurved = 3.5;
  // -, least damping ratio of the fastest mode of the sheet as built. Without damping, slivers that crumple gain
  // energy.
  constexpr double kLeastDamping = 0.05;
  constexpr double kTwice = 0.5;  // -, alpha of LocalInertia without damping, twice the smallest stable one
  const Reference built = reference(model);
  if (!options_.has_local_inertia || !(built.omega > 0.0)) return std::nullopt;
  const double nominal = model.bending().rest(model.element_blocks()).rest.empty() ? kNominal : kCurved;
  if (omega_ <= nominal * built.omega) return inertia_terms_of_bending(model, built);

  omega_ = nominal * built.omega;
  // The damping time is that of the sheet as built, not that of the much faster modes.
  const double damping_ratio = nominal * std::max(options_.highest_mode_damping, kLeastDamping);
  set_damping(model, std::min(damping_ratio, kMaxModeDamping));
  critical_step_ = critical_step(1.0);
  const double h = cfl() * critical_step_;
  InertiaTerms terms;
  terms.limit = omega_ * omega_;
  terms.added.membrane = terms.added.bending = kTwice * (1.0 + 2.0 * longest(beta_) / h) * h * h;
  add_terms_of_kicks(h, nominal * built.bending_omega, terms);
  return terms;
}

std::optional<InertiaTerms> ExplicitIntegrator::inertia_terms_of_bending(const Model& model, const Reference& built) {
  // -, ratio of a step length for which terms are made to the next one. As terms are made for few fixed step lengths,
  // most cuts leave them as they are.
  constexpr double kApart = 1.2;
  // -, highest frequency of bending outside the stiff parts over that of the sheet as built.
  constexpr double kHeadroom = 2.3;
  if (!model.materials().has_bending() || !(omega_ > 0.0) || bending_interval(plain_step_, 0.0) > 1)
    return std::nullopt;
  double pace = 1.0;  // -, frequency that the step resolves over that of the sheet as built
  while (pace * built.omega > omega_) pace /= kApart;
  while (pace * kApart * built.omega <= omega_) pace *= kApart;
  InertiaTerms terms;
  terms.limit = std::numeric_limits<double>::infinity();
  const double omega = std::exchange(omega_, pace * built.omega);
  set_damping(model, options_.highest_mode_damping);
  add_terms_of_kicks(cfl() * critical_step(1.0), kHeadroom * built.bending_omega, terms);
  omega_ = omega;
  set_damping(model, options_.highest_mode_damping);
  return terms.bending_limit > 0.0 ? std::optional(terms) : std::nullopt;
}

void ExplicitIntegrator::add_terms_of_kicks(double h, double built_omega, InertiaTerms& terms) {
  constexpr double kBelow = 0.999;  // -
  // Most substeps between kicks of bending with clusters. More would enlarge the clusters and hardly make a tick
  // cheaper.
  constexpr int kMostWithClusters = 3;
  const double bound = bending_omega_;
  bending_omega_ = built_omega;
  const int interval = std::min(bending_interval(h, 0.0), kMostWithClusters);
  bending_omega_ = bound;
  if (interval == 1) return;
  const double kick = interval * h;
  constexpr double kPiCubed = std::numbers::pi * std::numbers::pi * std::numbers::pi;
  // Kicks are stable by themselves, and damped if modes swing at their pace: see bending_interval().
  const double damped = kPiCubed * xi_ / (kick * omega_);
  terms.bending_limit = kBelow * std::min(kLongestKick * kLongestKick, damped) / (kick * kick);
  terms.added.bending = (1.0 + 2.0 * longest(bending_beta_) / kick) / terms.bending_limit;
  bending_omega_ = std::min(bound, std::sqrt(terms.bending_limit));
}

void ExplicitIntegrator::set_damping(const Model& model, double damping_ratio_wanted) {
  const double limit = std::max(kMaxModeDamping, options_.highest_mode_damping);
  largest_xi_ = 0.0;
  xi_ = limit;
  beta_.clear();
  bending_beta_.clear();
  for (const double own : model.materials().stiffness_damping()) {
    const double damping_ratio = std::clamp(0.5 * own * omega_, damping_ratio_wanted, limit);
    beta_.push_back(omega_ > 0.0 ? 2.0 * damping_ratio / omega_ : 0.0);
    bending_beta_.push_back(std::min(beta_.back(), own));
    largest_xi_ = std::max(largest_xi_, damping_ratio);
    xi_ = std::min(xi_, damping_ratio);
  }
}

double ExplicitIntegrator::mobility(const Model& model, const Grab& grab) const {
  return inertia_.mobility(model, grab);
}

double ExplicitIntegrator::critical_step(double stiffening) const {
  const double omega = omega_ * std::sqrt(stiffening);
  const double xi = largest_xi_ * std::sqrt(stiffening);
  return omega > 0.0 ? 2.0 / omega * (std::sqrt(1.0 + xi * xi) - xi) : std::numeric_limits<double>::infinity();
}

double ExplicitIntegrator::cfl() const {
  // Measured on an undamped sheet, shaken until it held 360 J of waves, then left alone. With a cfl of 0.95 and 0.92 it
  // blew up. It gained 2 % of its energy a second with 0.85, 0.5 % with 0.78 and 0.2 % with 0.7. With 0.95 and a
  // damping ratio of 0.002 it came to rest.
  constexpr double kUndampedCfl = 0.7;     // -
  constexpr double kDampingRatio = 0.002;  // -
  return xi_ < kDampingRatio ? std::min(options_.cfl, kUndampedCfl) : options_.cfl;
}

double ExplicitIntegrator::planned_substeps(double dt) const {
  return substeps_below(cfl() * critical_step_, dt);
}

std::optional<LocalInertiaStats> ExplicitIntegrator::local_inertia(double dt) const {
  if (inertia_.empty()) return std::nullopt;
  LocalInertiaStats stats;
  stats.clusters = static_cast<int>(inertia_.clusters().size());
  stats.vertices = static_cast<int>(inertia_.num_vertices());
  stats.largest = static_cast<int>(inertia_.largest());
  stats.planned_substeps = planned_substeps(dt);
  stats.plain_substeps = substeps_below(plain_step_, dt);
  return stats;
}

TickCost ExplicitIntegrator::expected_cost(const Model& model, double dt, const TickCounts& last) const {
  const double substeps = std::min(planned_substeps(dt), static_cast<double>(options_.max_substeps));
  const bool is_mixed = options_.precision == Precision::kMixed && LeapfrogSweep<float>::may_hold(model);
  return cost_of(ExplicitCounts{.substeps = substeps,
                                .bending_interval = static_cast<double>(bending_interval(dt / substeps, 0.0)),
                                .slots = static_cast<double>(model.num_slots()),
                                .bending_entries = static_cast<double>(model.bending().rows().num_entries()),
                                .vertices = static_cast<double>(model.num_vertices()),
                                .clusters = static_cast<double>(inertia_.clusters().size()),
                                .cluster_entries = static_cast<double>(inertia_.num_entries()),
                                .is_double = !is_mixed || last.is_double},
                 last);
}

int ExplicitIntegrator::bending_interval(double h, double strain) const {
  constexpr double kLongestSwing = 2.2;  // rad, largest swing between kicks of a mode driven by tension; with
                                         // kLongestKick such modes are stable up to here
  constexpr double kPi = std::numbers::pi;
  for (int interval = kMaxBendingInterval; interval > 1; --interval) {
    const double bending_angle = interval * h * bending_omega_;
    const double membrane_angle = interval * h * omega_;
    const bool is_stable = bending_angle < kLongestKick;
    const bool is_damped = bending_angle * bending_angle * membrane_angle < kPi * kPi * kPi * xi_;
    const bool is_below_resonance = membrane_angle * std::sqrt(strain) < kLongestSwing;
    if (is_stable && is_damped && is_below_resonance) return interval;
  }
  return 1;
}

int ExplicitIntegrator::substeps_stretched(double duration, double strain) const {
  constexpr double kLittle = 0.25;         // -, strain up to which the cfl number has enough margin
  constexpr double kStiffening = 1.0 / 8;  // -, growth of omega per strain; measured factors of omega are 1.06 at a
                                           // strain of 0.5, 1.09 at 1 and 1.19 at 2
  if (strain <= kLittle) return 0;
  const double wanted = substeps_below(cfl() * critical_step_ / (1.0 + kStiffening * strain), duration);
  return static_cast<int>(std::min<double>(wanted, options_.max_substeps));
}

int ExplicitIntegrator::with_calm_share(const Plan& plan, int substeps) const {
  if (!plan.is_calm) return substeps;
  return static_cast<int>(std::min<double>(std::ceil(kCalmSubsteps * substeps), options_.max_substeps));
}

int ExplicitIntegrator::even_interval(int substeps, int longest) const {
  const int most = std::max(substeps, std::min(options_.max_substeps, substeps + substeps / 20));
  for (int interval = longest; interval > 1; --interval) {
    if ((substeps + interval - 1) / interval * interval <= most) return interval;
  }
  return 1;
}

int ExplicitIntegrator::set_substeps(const Model& model, int least, double tension, Plan& plan) const {
  plan.substeps = least;
  if (plan.is_calm || !model.materials().has_bending()) return 1;
  const int interval = even_interval(least, bending_interval(plan.h(), tension));
  plan.substeps = (least + interval - 1) / interval * interval;
  return interval;
}

double ExplicitIntegrator::substeps_below(double longest, double dt) {
  return std::max(1.0, std::ceil(dt / longest));
}

}  // namespace kerf::fem
