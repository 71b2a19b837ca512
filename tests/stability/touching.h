#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "server/core/fem/step/step_stats.h"
#include "server/core/scene/sheet_config.h"

// Defines the stability matrix of sheets that touch themselves: folded, crumpled and cut sheets, each combined with
// stiffness, thickness of contact, tick rate and integrator.
namespace kerf::stability {

struct TouchingStart {
  const char* name;
  scene::SheetConfig (*make)();
  // No triangle passes through another or lies in one, and nothing forces them to, so none may pass later.
  bool is_apart = true;
};
const std::vector<TouchingStart>& touching_starts();

struct TouchingCase {
  std::size_t start = 0;          // index into touching_starts()
  double youngs_modulus = 1.0e6;  // Pa
  double thickness = 5.0e-4;      // m, distance that self-contact keeps
  double tick_rate = 60.0;        // Hz
  scene::IntegratorKind kind = scene::IntegratorKind::kAutomatic;

  [[nodiscard]] std::string name() const;
};
void PrintTo(const TouchingCase& tested, std::ostream* out);

// Cases of each start, at most 45: stiffness {1 .. 1e12 Pa}, thickness {1e-6 .. 0.1 m} and tick rate {4 .. 1000 Hz}.
// Their order is a fixed shuffle, so that the first cases of a start are a fair sample.
inline constexpr std::size_t kTouchingPerStart = 15;
std::vector<TouchingCase> touching_matrix(std::size_t per_start = kTouchingPerStart);

struct TouchingOutcome {
  bool finite = true;   // true if every tick had finite results
  bool frozen = false;  // true if a tick failed
  // -, highest energy minus initial energy, over the larger of the initial energy and m g 1 m; 0 where constraints do
  // work.
  double gain = 0.0;
  std::int64_t passing = 0;   // most pairs of triangles that pass through each other after a tick
  std::int64_t contacts = 0;  // pairs that responded, in all
  int num_ticks = 0;
  std::array<int, fem::kStepFlagNames.size()> flags{};  // number of ticks with each flag
  std::string integrator;
};

// Returns true if a case must not pass through itself where it was apart, nor gain more than m g 1 m or its energy at
// the start. Stiffer sheets must stay finite.
[[nodiscard]] bool is_soft(const TouchingCase& tested);
// Returns what is wrong with an outcome; empty if nothing is.
[[nodiscard]] std::string fault_of(const TouchingCase& tested, const TouchingOutcome& outcome);

// Runs a case for at most `num_ticks` ticks, for fewer if they need many substeps or contacts.
TouchingOutcome run(const TouchingCase& tested, int num_ticks);

}  // namespace kerf::stability
