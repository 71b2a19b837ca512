// Runs the stability matrix of sheets that touch themselves and prints the results by start:
//   stability_touching [cases per start] [ticks] [start]
// If a start is given, only its cases run. The exit status is 1 if a case is not finite or a tick fails. It is also 1
// if a soft sheet that is apart at first passes through itself, or gains more energy than it may.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/stability/touching.h"

namespace {

using kerf::stability::TouchingCase;
using kerf::stability::TouchingOutcome;

// Results of the cases of one start.
struct TouchingRow {
  int cases = 0, touching = 0, not_finite = 0, frozen = 0;
  std::int64_t passing = 0;
  double soft_gain = 0.0, stiff_gain = 0.0;
  std::array<long, kerf::fem::kStepFlagNames.size()> flags{};

  void add(const TouchingCase& tested, const TouchingOutcome& outcome) {
    ++cases;
    touching += outcome.contacts > 0 ? 1 : 0;
    not_finite += outcome.finite ? 0 : 1;
    frozen += outcome.frozen ? 1 : 0;
    passing = std::max(passing, outcome.passing);
    double& gain = kerf::stability::is_soft(tested) ? soft_gain : stiff_gain;
    gain = std::max(gain, outcome.gain);
    for (std::size_t i = 0; i < flags.size(); ++i) flags[i] += outcome.flags[i];
  }
};

void print(const char* name, const TouchingRow& row) {
  std::printf("| %s | %d | %d | %d | %d | %ld | %.1e | %.1e |", name, row.cases, row.touching, row.not_finite,
              row.frozen, static_cast<long>(row.passing), row.soft_gain, row.stiff_gain);
  for (const long count : row.flags) std::printf(" %ld |", count);
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t per_start = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : kerf::stability::kTouchingPerStart;
  const int ticks = argc > 2 ? std::atoi(argv[2]) : 40;
  const std::string only = argc > 3 ? argv[3] : "";
  std::vector<TouchingCase> cases = kerf::stability::touching_matrix(per_start);
  if (!only.empty()) {
    std::erase_if(
        cases, [&](const TouchingCase& each) { return kerf::stability::touching_starts()[each.start].name != only; });
  }
  std::vector<TouchingRow> rows(kerf::stability::touching_starts().size());
  TouchingRow all;
  int faults = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    std::fprintf(stderr, "\r%zu of %zu: %-80s", i + 1, cases.size(), cases[i].name().c_str());
    const TouchingOutcome outcome = kerf::stability::run(cases[i], ticks);
    rows[cases[i].start].add(cases[i], outcome);
    all.add(cases[i], outcome);
    const std::string fault = kerf::stability::fault_of(cases[i], outcome);
    faults += fault.empty() ? 0 : 1;
    const bool is_apart = kerf::stability::touching_starts()[cases[i].start].is_apart;
    if (fault.empty() && outcome.gain <= 1.0 && (!is_apart || outcome.passing == 0)) continue;
    std::fprintf(stderr, "\n%s: %s, energy %+.2e, %ld pairs pass, %s\n", cases[i].name().c_str(),
                 fault.empty() ? "stiff" : fault.c_str(), outcome.gain, static_cast<long>(outcome.passing),
                 outcome.integrator.c_str());
  }
  std::fprintf(stderr, "\n");
  std::printf(
      "| start | cases | that touched | not finite | frozen | most pairs that pass | worst gain, soft | stiff |");
  for (const std::string_view name : kerf::fem::kStepFlagNames) std::printf(" %s |", std::string(name).c_str());
  std::printf("\n|---|---|---|---|---|---|---|---|");
  for (std::size_t i = 0; i < kerf::fem::kStepFlagNames.size(); ++i) std::printf("---|");
  std::printf("\n");
  for (std::size_t start = 0; start < rows.size(); ++start) {
    if (rows[start].cases > 0) print(kerf::stability::touching_starts()[start].name, rows[start]);
  }
  print("all", all);
  return faults == 0 ? 0 : 1;
}
