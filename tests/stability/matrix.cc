// Runs the stability matrix and prints the results by start: stability_matrix [cases per start] [steps] [start]. If a
// start is given, only its cases run. The exit status is 1 if a case is not finite, or an accurate one does not keep
// its energy and momentum.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/stability/case.h"

namespace {

using kerf::stability::Case;
using kerf::stability::Outcome;

// Results of the cases of one start.
struct Row {
  int cases = 0, not_finite = 0, failed = 0;
  std::array<int, 3> classes{};  // number of cases of class A, B, C: see fem::ConditionClass
  std::array<double, 3> gain{};  // largest gain of each class
  double drift = 0.0;
  std::array<long, kerf::fem::kStepFlagNames.size()> flags{};

  void add(const Outcome& outcome) {
    ++cases;
    not_finite += outcome.finite ? 0 : 1;
    const auto rating = kerf::fem::rate_condition(outcome.condition);
    const auto rank = static_cast<std::size_t>(rating);
    ++classes[rank];
    gain[rank] = std::max(gain[rank], outcome.gain);
    if (rating == kerf::fem::ConditionClass::kAccurate) drift = std::max(drift, outcome.drift);
    for (std::size_t i = 0; i < flags.size(); ++i) flags[i] += outcome.flags[i];
  }
};

void print(const char* name, const Row& row) {
  std::printf("| %s | %d | %d | %d / %d / %d | %.1e | %.1e | %.1e | %.1e |", name, row.cases, row.not_finite,
              row.classes[0], row.classes[1], row.classes[2], row.gain[0], row.gain[1], row.gain[2], row.drift);
  for (const long count : row.flags) std::printf(" %ld |", count);
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t per_start = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : kerf::stability::kPerStart;
  const std::string only = argc > 3 ? argv[3] : "";
  const int num_steps = argc > 2 ? std::atoi(argv[2]) : 600;
  std::vector<Case> cases = kerf::stability::matrix(per_start);
  if (!only.empty()) {
    std::erase_if(cases, [&](const Case& each) { return kerf::stability::start_kinds()[each.start].name != only; });
  }
  std::vector<Row> rows(kerf::stability::start_kinds().size());
  Row all;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    std::fprintf(stderr, "\r%zu of %zu: %-80s", i + 1, cases.size(), cases[i].name().c_str());
    const Outcome outcome = kerf::stability::run(cases[i], num_steps, kerf::stability::kMatrixBudget);
    rows[cases[i].start].add(outcome);
    all.add(outcome);
    const bool is_accurate = kerf::fem::rate_condition(outcome.condition) == kerf::fem::ConditionClass::kAccurate;
    const bool keeps = outcome.gain <= (outcome.is_explicit ? 1e-2 : 1e-4) && outcome.drift <= 1e-6;
    if (!outcome.finite || (is_accurate && !keeps)) {
      ++all.failed;
      std::fprintf(stderr, "\n%s: %s, energy %+.2e, drift %.1e, condition %.1e, %s\n", cases[i].name().c_str(),
                   outcome.finite ? "finite" : "NOT FINITE", outcome.gain, outcome.drift, outcome.condition,
                   outcome.integrator.c_str());
    }
  }
  std::fprintf(stderr, "\n");
  std::printf(
      "| start | cases | not finite | class A / B / C | worst gain of energy, A | B | C | drift of the centre, A |");
  for (const std::string_view name : kerf::fem::kStepFlagNames) std::printf(" %s |", std::string(name).c_str());
  std::printf("\n|---|---|---|---|---|---|---|---|");
  for (std::size_t i = 0; i < kerf::fem::kStepFlagNames.size(); ++i) std::printf("---|");
  std::printf("\n");
  for (std::size_t start = 0; start < rows.size(); ++start) {
    if (rows[start].cases > 0) print(kerf::stability::start_kinds()[start].name, rows[start]);
  }
  print("all", all);
  return all.failed == 0 ? 0 : 1;
}
