#include "tests/stability/touching.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string_view>
#include <utility>

#include "server/base/random.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/sheet/sheet.h"
#include "tests/support/self_contact_scenes.h"

namespace kerf::stability {
namespace {

constexpr std::int32_t kSide = 8;  // vertices along a side

constexpr std::array kTouchingModuli{1.0, 1e3, 1e6, 1e9, 1e12};                               // Pa
constexpr std::array kThicknesses{scene::kMinSelfThickness, 5e-4, scene::kMaxSelfThickness};  // m
constexpr std::array kTickRates{4.0, 60.0, 1000.0};                                           // Hz
constexpr std::array kKinds{scene::IntegratorKind::kAutomatic, scene::IntegratorKind::kExplicitLeapfrog,
                            scene::IntegratorKind::kTrBdf2, scene::IntegratorKind::kImplicitEuler};

// A sheet above a floor whose vertices are at place(material position), m.
template <typename Place>
scene::SheetConfig placed_at(const Place& place) {
  scene::SheetConfig config = scenes::falls_on_edge(kSide);
  auto& source = std::get<scene::ArraySource>(config.mesh);
  for (Eigen::Index v = 0; v < source.positions.cols(); ++v) {
    source.positions.col(v) = place(Eigen::Vector2d(source.material_positions.col(v)));
  }
  return config;
}

scene::SheetConfig in_a_box() {
  SeededRandom random(7);
  return placed_at([&](const Eigen::Vector2d& /*at*/) {
    return Eigen::Vector3d(random.uniform(0.0, 0.2), random.uniform(0.0, 0.2), random.uniform(0.1, 0.3));
  });
}

// Slits at tick 24, whatever the rate of ticks.
scene::SheetConfig cut_while_it_falls() {
  scene::SheetConfig config = scenes::cut_in_the_pile(kSide);
  for (scene::ScheduledCommand& command : config.commands) command.tick = 24;
  return config;
}

}  // namespace

const std::vector<TouchingStart>& touching_starts() {
  static const std::vector<TouchingStart> starts{
      {"falls on its edge", [] { return scenes::falls_on_edge(kSide); }},
      {"folded twice", [] { return scenes::folded_twice(kSide); }},
      {"falls in strips", [] { return scenes::falls_in_strips(kSide + 3); }},
      {"thrown on a layer", [] { return scenes::thrown_on_a_layer(kSide); }},
      {"stack of ten", [] { return scenes::stack_of_ten(3); }},
      {"cut while it falls", cut_while_it_falls},
      {"falls after 12 cuts", [] { return scenes::falls_after_cuts(kSide, 3, 12); }},
      {"twisted", [] { return scenes::twisted_strip(14); }, false},
      {"random box", in_a_box, false},
      {"folded flat",
       [] {
         return placed_at(
             [](const Eigen::Vector2d& at) { return Eigen::Vector3d(std::min(at.x(), 1.0 - at.x()), at.y(), 0.01); });
       },
       false},
      {"line", [] { return placed_at([](const Eigen::Vector2d& at) { return Eigen::Vector3d(at.x(), 0.0, 0.01); }); },
       false},
      {"point", [] { return placed_at([](const Eigen::Vector2d&) { return Eigen::Vector3d(0.0, 0.0, 0.5); }); }, false},
  };
  return starts;
}

std::string TouchingCase::name() const {
  constexpr std::array<std::string_view, kKinds.size()> kNames{"automatic", "explicit", "TR-BDF2", "Euler"};
  const auto found = std::find(kKinds.begin(), kKinds.end(), kind);
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%s, E %.0e Pa, thickness %.0e m, %g Hz, %s", touching_starts()[start].name,
                youngs_modulus, thickness, tick_rate, kNames[static_cast<std::size_t>(found - kKinds.begin())].data());
  return text.data();
}

void PrintTo(const TouchingCase& tested, std::ostream* out) {
  *out << tested.name();
}

std::vector<TouchingCase> touching_matrix(std::size_t per_start) {
  constexpr std::size_t kAll = kTouchingModuli.size() * kThicknesses.size() * kTickRates.size();
  std::vector<TouchingCase> cases;
  for (std::size_t start = 0; start < touching_starts().size(); ++start) {
    std::vector<std::size_t> order(kAll);
    std::iota(order.begin(), order.end(), std::size_t{0});
    SeededRandom random(500 + start);
    for (std::size_t i = kAll - 1; i > 0; --i) std::swap(order[i], order[random.below(i + 1)]);
    for (std::size_t i = 0; i < std::min(per_start, kAll); ++i) {
      TouchingCase made;
      made.start = start;
      made.youngs_modulus = kTouchingModuli[order[i] % kTouchingModuli.size()];
      made.thickness = kThicknesses[order[i] / kTouchingModuli.size() % kThicknesses.size()];
      made.tick_rate = kTickRates[order[i] / (kTouchingModuli.size() * kThicknesses.size())];
      made.kind = kKinds[(i + start) % kKinds.size()];
      cases.push_back(made);
    }
  }
  return cases;
}

bool is_soft(const TouchingCase& tested) {
  return tested.youngs_modulus <= 1e6;
}

std::string fault_of(const TouchingCase& tested, const TouchingOutcome& outcome) {
  if (!outcome.finite) return "NOT FINITE";
  if (outcome.frozen) return "FROZEN";
  if (!is_soft(tested)) return "";
  if (touching_starts()[tested.start].is_apart && outcome.passing > 0) return "PASSES THROUGH ITSELF";
  return outcome.gain > 1.0 ? "GAINS ENERGY" : "";
}

TouchingOutcome run(const TouchingCase& tested, int num_ticks) {
  constexpr long kMostSubsteps = 5'000, kMostContacts = 100'000;  // in all; looked at after each tick
  scene::SheetConfig config = touching_starts()[tested.start].make();
  config.material.youngs_modulus_1 = config.material.youngs_modulus_2 = tested.youngs_modulus;
  config.material.shear_modulus = 0.5 * tested.youngs_modulus / (1.0 + config.material.poissons_ratio_12);
  config.self_contact = {true, 0.3, tested.thickness};
  config.tick_rate_hz = tested.tick_rate;
  config.integrator.kind = tested.kind;
  config.integrator.max_substeps = 500;
  const bool is_free = config.constraints.empty();
  sheet::Sheet sheet = sheet::Sheet::create(std::move(config)).value();
  TouchingOutcome outcome;
  outcome.integrator = sheet.integrator_description();
  const double first = sheet.energies().total();
  const double scale = std::max(std::abs(first), 9.81 * sheet.model().masses().total());
  long substeps = 0;
  while (outcome.num_ticks < num_ticks && substeps < kMostSubsteps && outcome.contacts < kMostContacts &&
         outcome.finite && !outcome.frozen) {
    const sheet::TickReport report = sheet.step({});
    ++outcome.num_ticks;
    substeps += std::max(report.stats.substeps, 1);
    for (std::size_t bit = 0; bit < outcome.flags.size(); ++bit) {
      outcome.flags[bit] += static_cast<int>((report.stats.flags >> bit) & 1U);
    }
    outcome.frozen = report.frozen || report.step_failed;
    outcome.finite = fem::is_finite(sheet.state());
    outcome.passing = std::max(outcome.passing, report.stats.self_contact.intersections);
    outcome.contacts += report.stats.self_contact.contacts;
    if (is_free) outcome.gain = std::max(outcome.gain, (sheet.energies().total() - first) / scale);
  }
  return outcome;
}

}  // namespace kerf::stability
