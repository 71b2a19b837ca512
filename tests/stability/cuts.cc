// Cuts a hanging sheet very often, then lets it move: stability_cuts [cuts] [vertices a side] [ticks after] [tr-bdf2].
// Slits at random places are up to two edge lengths long; a tenth of them come between one tick and the next. The exit
// status is 1 if a number is not finite, a step failed, or energy was gained. It is also 1 if mesh or model differ from
// newly built ones.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <vector>

#include "server/base/random.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/stage_observer.h"
#include "tests/support/scenes.h"

namespace {

using kerf::sheet::Sheet;
using kerf::sheet::TickReport;

struct Run {
  Sheet sheet;
  double gain = 0.0;          // J, largest excess over start_energy + of_cuts in all ticks so far
  double start_energy = 0.0;  // J
  double of_cuts = 0.0;       // J, energy added by cuts, which move mass, and so weight, between vertices
  long num_applied = 0, num_ticks = 0, num_failed = 0, num_not_finite = 0;
  unsigned flags = 0;
};

double energy_of(const Sheet& sheet) {
  const kerf::sheet::Energies energies = sheet.energies();
  return energies.kinetic + energies.membrane + std::max(0.0, energies.bending) + energies.gravity;
}

kerf::scene::Command make_cut(kerf::SeededRandom& random, double edge) {
  const Eigen::Vector2d from(random.uniform(0.0, 1.0), random.uniform(0.0, 1.0));
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  const double length = edge * random.uniform(0.3, 2.0);
  const Eigen::Vector2d along = length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  return kerf::scenes::line_cut(from, from + along);
}

// Records the energy after the cuts of a tick, before the tick is integrated.
class AfterCuts final : public kerf::sheet::StageObserver {
 public:
  explicit AfterCuts(const Sheet& sheet) : sheet_(sheet) {}
  void begin(kerf::sheet::Stage stage, std::int32_t /*command*/) override {
    if (stage == kerf::sheet::Stage::kIntegrate) energy_ = energy_of(sheet_);
  }
  void end(kerf::sheet::Stage /*stage*/, std::int32_t /*command*/) override {}
  [[nodiscard]] double energy() const { return energy_; }

 private:
  const Sheet& sheet_;
  double energy_ = 0.0;  // J
};

void advance(Run& run, const std::vector<kerf::scene::Command>& cuts) {
  const double before = energy_of(run.sheet);
  AfterCuts after_cuts(run.sheet);
  const TickReport report = run.sheet.step(cuts, &after_cuts);
  run.of_cuts += after_cuts.energy() - before;
  const kerf::fem::State& state = run.sheet.state();
  for (const kerf::Result<kerf::scene::CommandReply>& reply : report.replies) {
    const bool is_applied = reply.ok() && reply->cut && reply->cut->status == kerf::cut::CutStatus::kApplied;
    run.num_applied += is_applied ? 1 : 0;
  }
  ++run.num_ticks;
  run.flags |= report.stats.flags;
  run.num_failed += report.step_failed ? 1 : 0;
  run.num_not_finite += state.x.allFinite() && state.v.allFinite() ? 0 : 1;
  run.gain = std::max(run.gain, energy_of(run.sheet) - run.start_energy - run.of_cuts);
}

}  // namespace

int main(int argc, char** argv) {
  const int num_cuts = argc > 1 ? std::atoi(argv[1]) : 10'000;
  const int num_side = argc > 2 ? std::atoi(argv[2]) : 200;
  const int num_after = argc > 3 ? std::atoi(argv[3]) : 20;
  kerf::scene::SheetConfig config = kerf::scenes::hanging(num_side);
  if (argc > 4 && std::strcmp(argv[4], "tr-bdf2") == 0) {
    config.integrator.kind = kerf::scene::IntegratorKind::kTrBdf2;
    config.integrator.solver = kerf::scene::LinearSolverKind::kDirect;
  }
  kerf::Result<Sheet> made = Sheet::create(config);
  if (!made.ok()) {
    std::fprintf(stderr, "%s\n", made.error().message.c_str());
    return 2;
  }
  Run run{*std::move(made)};
  run.start_energy = energy_of(run.sheet);
  kerf::SeededRandom random(29);
  const int num_between = std::max(1, num_cuts / 10);
  std::vector<kerf::scene::Command> cuts;
  for (int i = 1; i <= num_cuts; ++i) {
    cuts.push_back(make_cut(random, 1.0 / (num_side - 1)));
    if (i % num_between != 0) continue;
    advance(run, cuts);
    cuts.clear();
    std::fprintf(stderr, "\r%d of %d cuts, %d vertices", i, num_cuts, run.sheet.mesh().num_vertices());
  }
  if (!cuts.empty()) advance(run, cuts);
  for (int i = 0; i < num_after; ++i) {
    advance(run, {});
    std::fprintf(stderr, "\r%d of %d ticks after                        ", i + 1, num_after);
  }
  const bool is_valid = !run.sheet.mesh().find_violation();
  const bool is_fresh =
      run.sheet.model().hash() == kerf::fem::Model(run.sheet.mesh(), run.sheet.config().material).hash();
  const double moved = 9.81 * run.sheet.model().masses().total();  // J, energy of a fall by 1 m
  std::printf("\ncuts made: %ld of %d; vertices: %d; ticks: %ld; not finite: %ld; failed: %ld; flags: %#x\n",
              run.num_applied, num_cuts, run.sheet.mesh().num_vertices(), run.num_ticks, run.num_not_finite,
              run.num_failed, run.flags);
  std::printf(
      "most energy over that of the start: %.2e of m g 1 m, beside %.2e by cuts; mesh %s; model %s a fresh one\n",
      run.gain / moved, run.of_cuts / moved, is_valid ? "valid" : "NOT VALID", is_fresh ? "equals" : "DIFFERS FROM");
  const bool is_kept = run.gain <= 1e-4 * moved && run.num_failed == 0 && run.num_not_finite == 0;
  return is_kept && is_valid && is_fresh && run.num_applied > 0 ? 0 : 1;
}
