// A sheet is saved at a random tick of a random run and loaded again. Both continue side by side, and must stay equal.

#include <array>
#include <cstdio>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "tests/sheet/calls.h"
#include "tests/support/scenes.h"
#include "tests/support/trials.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct RunKind {
  scene::IntegratorKind integrator;
  scene::LinearSolverKind solver;
  scene::Precision precision;
  bool touches_itself;
};

constexpr std::array kRunKinds{
    RunKind{scene::IntegratorKind::kExplicitLeapfrog, {}, scene::Precision::kMixed, false},
    RunKind{scene::IntegratorKind::kExplicitLeapfrog, {}, scene::Precision::kDouble, false},
    RunKind{scene::IntegratorKind::kExplicitLeapfrog, {}, scene::Precision::kMixed, true},
    RunKind{scene::IntegratorKind::kAutomatic, {}, scene::Precision::kMixed, false},
    RunKind{scene::IntegratorKind::kImplicitEuler, scene::LinearSolverKind::kFactorCg, {}, false},
    RunKind{scene::IntegratorKind::kTrBdf2, scene::LinearSolverKind::kMultigridCg, {}, true},
    RunKind{scene::IntegratorKind::kBdf2, scene::LinearSolverKind::kDirect, {}, false},
    RunKind{scene::IntegratorKind::kTrBdf2, scene::LinearSolverKind::kBlockJacobiCg, {}, false},
};

// Random commands of every kind; many are refused, by both sheets alike.
class RandomCommands {
 public:
  RandomCommands(std::uint64_t seed, bool touches_itself) : random_(seed), touches_itself_(touches_itself) {}

  Vector2d place() { return {random_.uniform(-0.1, 1.1), random_.uniform(-0.1, 1.1)}; }
  Vector3d anywhere() { return {random_.uniform(), random_.uniform(-0.3, 0.3), random_.uniform()}; }
  [[nodiscard]] bool touches_itself() const { return touches_itself_; }  // then little is cut, as steps are slow
  std::uint64_t below(std::uint64_t bound) { return random_.below(bound); }

  scene::Cut cut() {
    switch (below(4)) {
      case 0:
        return scenes::circle_cut(place(), random_.uniform(0.05, 0.2));
      case 1:
        return scenes::bezier_cut(place(), place(), place(), place());
      default: {
        scene::Cut line = scenes::line_cut(place(), place());
        if (!touches_itself_ && below(3) == 0) line.options.width_m = random_.uniform(0.01, 0.05);
        return line;
      }
    }
  }

  scene::Command next() {
    const std::string hand = below(2) == 0 ? "left" : "right";
    switch (below(16)) {
      case 0:
      case 1:
      case 2:
        return cut();
      case 3:
        return scene::CutBatch{{cut(), cut()}};
      case 4:
      case 5:
      case 6:
        return scene::UndoCut{};
      case 7:
        return scene::RedoCut{};
      case 8:
        return scene::Reset{.repeats = below(4) == 0};
      case 9:
        return scene::Grab{hand, place(), std::nullopt, 0.0};
      case 10:
        return scene::Grab{hand, static_cast<mesh::VertexId>(below(60)), anywhere(), 20.0};
      case 11:
        return scene::Drag{hand, anywhere()};
      case 12:
        return scene::Release{hand};
      case 13: {
        if (touches_itself_) return scene::Release{hand};  // held lips that touch take minutes
        const bool is_top = below(2) == 0;
        return scene::SetPins{{is_top ? scene::RegionEdge::kTop : scene::RegionEdge::kLeft}};
      }
      case 14:
        return other_setting();
      default:
        return scene::SetWind{{Vector3d(random_.uniform(-3.0, 3.0), 2.0, 0.0), 1.2, 1.0}};
    }
  }

 private:
  scene::Command other_setting() {
    switch (below(3)) {
      case 0:
        return scene::SetGravity{Vector3d(0.0, random_.uniform(-3.0, 3.0), -9.0)};
      case 1:
        return scene::SetSelfContact{.is_on = below(2) == 0, .friction = random_.uniform(), .thickness = {}};
      default: {
        fem::Material softer = scenes::demo_material();
        softer.youngs_modulus_1 *= random_.uniform(0.5, 1.0);
        return scene::SetMaterial{softer, {}};
      }
    }
  }

  SeededRandom random_;
  bool touches_itself_;
};

const RunKind& kind_of(std::uint64_t seed) {
  return kRunKinds[seed % kRunKinds.size()];
}

scene::SheetConfig random_scene(std::uint64_t seed) {
  const RunKind& kind = kind_of(seed);
  RandomCommands random(seed, kind.touches_itself);
  scene::SheetConfig config = scenes::hanging(5 + static_cast<std::int32_t>(random.below(3)));
  config.integrator.kind = kind.integrator;
  config.integrator.solver = kind.solver;
  config.integrator.precision = kind.precision;
  config.self_contact.is_on = kind.touches_itself;
  config.material.direction = 0.3;
  switch (random.below(4)) {
    case 0:
      config.pins = {scene::RegionEdge::kTopCorners};
      break;
    case 1:
      config.placement.y_axis = {0.0, 1.0, 0.0};
      config.placement.origin = {0.0, 0.0, 0.02};
      config.pins.clear();
      break;
    case 2: {
      scene::Constraint turning;
      turning.region = scene::RegionEdge::kLeft;
      turning.rotation = scene::Rotation{{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, 0.5};
      turning.history = {{0.0, 2.0}, {0.0, 1.0}};
      turning.slope = random.below(2) == 0;
      config.constraints = {turning};
      break;
    }
    default:
      config.fidelity = scene::Fidelity::kRealTime;
  }
  if (random.below(2) == 0) {
    config.colliders = {{contact::Plane{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}, 0.5},
                        {contact::Sphere{{0.5, 0.0, 0.2}, 0.15}, 0.3}};
  }
  if (random.below(2) == 0) {
    config.loads = {{scene::PointForce{Vector2d(0.4, 0.4), {0.0, 0.05, 0.0}}, {{0.0, 3.0}, {0.0, 1.0}}},
                    {scene::PointForce{mesh::VertexId{9}, {0.0, 0.02, 0.0}}, {}},
                    {scene::Pressure{scene::WholeSheet{}, 0.2}, {}},
                    {scene::EdgeMoment{scene::RegionEdge::kBottom, 1e-6}, {}}};
  }
  for (int i = 0; i < (kind.touches_itself ? 1 : 4); ++i) {
    config.commands.push_back({1 + static_cast<std::int64_t>(random.below(40)), random.cut()});
  }
  return config;
}

void describe(std::ostream& out, const scene::CutReply& cut) {
  out << " " << static_cast<int>(cut.status) << " " << cut.number << " " << cut.report.pieces << " "
      << cut.report.new_vertices << " " << cut.removed_mass.value_or(0.0);
  for (const std::string& warning : cut.warnings) out << warning;
  for (const scene::SplitPiece& split : cut.split_pieces) {
    out << " " << split.id;
    for (const scene::Piece& child : split.children) out << ":" << child.birth.id << "=" << child.mass;
  }
}

// Returns everything that a report says, to the last digit.
std::string description(const TickReport& report) {
  std::ostringstream out;
  out.precision(17);
  const auto describe_reply = [&](const Result<scene::CommandReply>& reply) {
    if (!reply.ok()) {
      out << "; " << reply.error().reason << reply.error().message;
      return;
    }
    out << "; " << reply->tick << " " << reply->topology_version << " " << reply->state_hash << " " << reply->beginning;
    if (reply->cut) describe(out, *reply->cut);
    for (const scene::CutReply& cut : reply->batch) describe(out, cut);
    if (!reply->undone) return;
    for (const std::int64_t number : reply->undone->cuts) out << " undone " << number;
    out << " " << reply->undone->reset << reply->undone->pieces << " " << reply->undone->undo_steps << " "
        << reply->undone->redo_steps;
  };
  out << report.tick << report.advanced << report.step_failed << report.frozen << report.at_rest
      << report.topology_changed << report.stats.substeps << " " << report.stats.newton_iterations << " "
      << report.stats.linear_iterations << " " << report.stats.self_contact.contacts;
  for (const Result<scene::CommandReply>& reply : report.replies) describe_reply(reply);
  for (const ScheduledReply& scheduled : report.scheduled) describe_reply(scheduled.reply);
  return out.str();
}

std::vector<scene::Command> commands_of_a_tick(RandomCommands& random) {
  std::vector<scene::Command> commands;
  if (random.below(random.touches_itself() ? 12 : 5) == 0) commands.push_back(random.next());
  if (random.below(20) == 0) commands.push_back(random.next());
  return commands;
}

// The first difference between a sheet and the one that was loaded, and the hash of both at the end.
struct RunOutcome {
  std::string difference;
  std::uint64_t hash = 0;
};

RunOutcome run_beside_loaded(std::uint64_t seed, int ticks) {
  RandomCommands random(~seed, kind_of(seed).touches_itself);
  Result<Sheet> created = Sheet::create(random_scene(seed));
  if (!created.ok()) return {created.error().message};
  Sheet sheet = std::move(created).value();
  const auto saved_at = static_cast<int>(random.below(static_cast<std::uint64_t>(ticks)));
  for (int i = 0; i < saved_at; ++i) {
    const std::vector<scene::Command> commands = commands_of_a_tick(random);
    random.below(10) == 0 ? sheet.apply(commands) : sheet.step(commands);
  }
  std::string bytes;
  sheet.save([&](std::string_view part) { bytes += part; });
  Result<Sheet> loaded = Sheet::load(sheet.config(), bytes);
  if (!loaded.ok()) return {loaded.error().reason + ": " + loaded.error().message};
  for (int i = 0; i < ticks; ++i) {
    const std::vector<scene::Command> commands = commands_of_a_tick(random);
    const bool stands = random.below(10) == 0;
    const std::string expected = description(stands ? sheet.apply(commands) : sheet.step(commands));
    const std::string got = description(stands ? loaded->apply(commands) : loaded->step(commands));
    const std::string when = "saved at " + std::to_string(saved_at) + ", tick " + std::to_string(sheet.tick()) + ": ";
    if (got != expected) return {when + got + " instead of " + expected};
    if (loaded->state_hash() != sheet.state_hash()) return {when + "another state"};
    if (loaded->continuation_hash() != sheet.continuation_hash()) return {when + "another future"};
  }
  return {{}, sheet.continuation_hash()};
}

// The sheet is damped when it has been calm for 5 s, and rests when it has been watched for longer.
TEST(SavedRuns, ASheetThatCalmsDownRestsInTheSameTick) {
  scene::SheetConfig config = scenes::lying_on_floor(6);
  config.placement.origin.z() = 0.002;
  Sheet sheet = make(config);
  for (int i = 0; i < 1000 && !sheet.at_rest(); ++i) {
    if (i % 70 == 0) {
      std::string bytes;
      sheet.save([&](std::string_view part) { bytes += part; });
      Result<Sheet> loaded = Sheet::load(config, bytes);
      ASSERT_TRUE(loaded.ok());
      sheet.step({});
      loaded->step({});
      ASSERT_EQ(loaded->continuation_hash(), sheet.continuation_hash()) << "tick " << i;
      sheet = std::move(loaded).value();
    } else {
      sheet.step({});
    }
  }
  EXPECT_TRUE(sheet.at_rest());
  Sheet whole = make(config);
  while (!whole.at_rest()) whole.step({});
  EXPECT_EQ(sheet.continuation_hash(), whole.continuation_hash());
}

TEST(SavedRuns, ContinueAsIfNothingHadHappened) {
  const auto trials = test::only_seed() ? std::size_t{1} : static_cast<std::size_t>(test::num_trials({4, 8, 200}));
  const int ticks = test::num_trials({15, 20, 200});
  std::vector<RunOutcome> alone(trials), together(trials);
  const auto seed_of = [](std::size_t trial) { return test::only_seed().value_or(test::first_seed() + trial); };
  for (std::size_t i = 0; i < trials; ++i) {
    alone[i] = run_beside_loaded(seed_of(i), ticks);
    EXPECT_EQ(alone[i].difference, "") << "seed " << seed_of(i);
  }
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = t; i < trials; i += 8) together[i] = run_beside_loaded(seed_of(i), ticks);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < trials; ++i) EXPECT_EQ(together[i].hash, alone[i].hash) << "seed " << seed_of(i);
}

}  // namespace
}  // namespace kerf::sheet
