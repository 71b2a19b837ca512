// Properties of cuts, by rapidcheck: what fails is shrunk to the fewest cuts, points and cells that fail, and printed
// with the seed; run that again with RC_PARAMS="seed=...", as printed.
#include <array>
#include <cstdlib>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "server/core/cut/cut.h"
#include "tests/audit/audited_cut.h"
#include "tests/support/meshes.h"
#include "tests/support/trials.h"

namespace kerf::cut {

// A place on the unit square and somewhat around it, in 1/960: every grid of 3, 5, 6, 9, 11 or 13 vertices lies on it.
using Place = std::pair<int, int>;

struct Drawn {
  int kind = 0;  // 0 polyline, 1 closed polyline, 2 cubic Beziers, 3 circle
  std::vector<Place> places;
};

static Eigen::Vector2d at(const Place& place) {
  return {place.first / 960.0, place.second / 960.0};
}

// Nothing where a shrunk drawing has too few points.
static std::optional<Curve> curve_of(const Drawn& drawn) {
  std::vector<Eigen::Vector2d> points;
  for (const Place& place : drawn.places) points.push_back(at(place));
  if (drawn.kind == 3) {
    if (points.size() < 2 || points[0] == points[1]) return std::nullopt;
    return Circle{points[0], (points[1] - points[0]).norm()};
  }
  if (drawn.kind == 2) {
    const std::size_t pieces = points.empty() ? 0 : (points.size() - 1) / 3;
    if (pieces == 0) return std::nullopt;
    points.resize(3 * pieces + 1);
    return CubicBezier{points};
  }
  if (points.size() < 2) return std::nullopt;
  if (drawn.kind == 1) points.push_back(points.front());
  return Polyline{points};
}

}  // namespace kerf::cut

namespace rc {

template <>
struct Arbitrary<kerf::cut::Drawn> {
  static Gen<kerf::cut::Drawn> arbitrary() {
    // One in three on lines of the grids, so that much coincides.
    const auto coordinate = gen::oneOf(gen::inRange(-100, 1060), gen::inRange(0, 960),
                                       gen::map(gen::inRange(-1, 14), [](int cell) { return 80 * cell; }));
    return gen::build<kerf::cut::Drawn>(
        gen::set(&kerf::cut::Drawn::kind, gen::inRange(0, 4)),
        gen::set(&kerf::cut::Drawn::places,
                 gen::resize(10, gen::container<std::vector<kerf::cut::Place>>(gen::pair(coordinate, coordinate)))));
  }
};

}  // namespace rc

namespace kerf::cut {

// NOLINTNEXTLINE(misc-use-internal-linkage)
void showValue(const Drawn& drawn, std::ostream& out) {  // NOLINT(readability-identifier-naming): rapidcheck's name
  constexpr std::array<const char*, 4> kKinds{"polyline", "closed polyline", "bezier", "circle"};
  out << kKinds[static_cast<std::size_t>(drawn.kind)];
  for (const Place& place : drawn.places) out << " (" << place.first << ", " << place.second << ")";
}

namespace {

struct Scene {
  mesh::TriangleMesh mesh;
  CutOptions options;
};

Scene any_scene() {
  constexpr std::array<int, 6> kSizes{3, 5, 6, 9, 11, 13};
  const int size = kSizes[static_cast<std::size_t>(*rc::gen::inRange(0, 6).as("size of the grid"))];
  const bool jittered = *rc::gen::arbitrary<bool>().as("jittered");
  Scene scene{jittered ? test::jittered_grid(size, 3) : test::grid(size), {}};
  scene.options.relax = *rc::gen::arbitrary<bool>().as("relax");
  if (*rc::gen::arbitrary<bool>().as("plain")) scene.options.min_angle_deg = 0.0;
  if (*rc::gen::inRange(0, 3).as("strips, if 0") == 0) {
    scene.options.width_m = *rc::gen::inRange(1, 160).as("width in 1/960") / 960.0;
  }
  return scene;
}

// True for the permitted refusal: no material would be left.
bool is_fair_refusal(const std::string& reason) {
  return reason == "STRIP_COVERS_SHEET";
}

std::vector<Curve> any_curves() {
  const auto drawn = *rc::gen::resize(4, rc::gen::arbitrary<std::vector<Drawn>>()).as("curves");
  std::vector<Curve> curves;
  for (const Drawn& one : drawn) {
    if (const std::optional<Curve> curve = curve_of(one)) curves.push_back(*curve);
  }
  return curves;
}

// rapidcheck takes its settings from the environment, at first use.
bool check(const char* what, const std::function<void()>& property) {
  const int num_sequences = test::num_trials({.few = 60, .usual = 1'000, .many = 4'000});  // of up to four cuts
  const std::string settings =
      "seed=" + std::to_string(20 + test::chosen_seed()) + " max_size=60 max_success=" + std::to_string(num_sequences);
  setenv("RC_PARAMS", settings.c_str(), 0);
  return rc::check(what, property);
}

TEST(CutProperties, AnySequenceOfCutsKeepsEveryInvariant) {
  EXPECT_TRUE(check("audit", [] {
    Scene scene = any_scene();
    for (const Curve& curve : any_curves()) {
      const audit::AuditedCut done = audit::cut_and_audit(scene.mesh, {curve, scene.options, {}}, audit::kDeepest);
      RC_ASSERT(done.flaw.value_or("") == "");
      if (done.end == audit::AuditedCut::End::kRefused) RC_ASSERT(is_fair_refusal(done.reason));
    }
  }));
}

TEST(CutProperties, UndoneInReverseOrderTheSheetIsAsBuilt) {
  EXPECT_TRUE(check("undo", [] {
    Scene scene = any_scene();
    const mesh::TriangleMesh built = scene.mesh;
    std::vector<mesh::UndoLog> logs;
    for (const Curve& curve : any_curves()) {
      const Result<CutPlan> planned = plan(scene.mesh, {curve, scene.options, {}});
      if (!planned.ok()) continue;
      Result<CutOutcome> done = apply(scene.mesh, *planned);
      if (!done.ok()) {
        RC_ASSERT(is_fair_refusal(done.error().reason));
        continue;
      }
      if (done->status == CutStatus::kApplied) logs.push_back(std::move(done->undo));
    }
    for (; !logs.empty(); logs.pop_back()) logs.back().undo(scene.mesh);
    RC_ASSERT(audit::find_difference(built, scene.mesh).value_or("") == "");
  }));
}

// With a width as well. Of other curves see repeated_cuts_test.cc.
TEST(CutProperties, TheSameStraightCutTwiceIsAMiss) {
  EXPECT_TRUE(check("twice", [] {
    Scene scene = any_scene();
    const auto place = rc::gen::pair(rc::gen::inRange(-100, 1060), rc::gen::inRange(-100, 1060));
    const Eigen::Vector2d from = at(*place.as("from"));
    const Eigen::Vector2d to = at(*place.as("to"));
    RC_PRE((to - from).norm() > 0.01);
    const Curve line = Polyline{{from, to}};
    audit::AuditedCut done = audit::cut_and_audit(scene.mesh, {line, scene.options, {}});
    RC_ASSERT(done.flaw.value_or("") == "");
    RC_PRE(!is_fair_refusal(done.reason));
    done = audit::cut_and_audit(scene.mesh, {line, scene.options, {}});
    RC_ASSERT(done.flaw.value_or("") == "");
    RC_ASSERT((done.end == audit::AuditedCut::End::kMissed));
  }));
}

}  // namespace
}  // namespace kerf::cut
