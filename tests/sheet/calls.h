#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/mesh/build/mesh_import.h"
#include "server/core/sheet/recording.h"
#include "server/core/sheet/sheet.h"
#include "tests/support/scenes.h"

// A test's short ways to make, step and command a sheet.
namespace kerf::sheet {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline Sheet make(scene::SheetConfig config) {
  Result<Sheet> created = Sheet::create(std::move(config));
  if (!created.ok()) ADD_FAILURE() << created.error().message;
  return std::move(created).value();
}

inline void run(Sheet& sheet, int ticks) {
  for (int i = 0; i < ticks; ++i) sheet.step({});
}

inline Result<scene::CommandReply> apply(Sheet& sheet, scene::Command command) {
  const std::vector<scene::Command> commands{std::move(command)};
  TickReport report = sheet.apply(commands);
  return std::move(report.replies.at(0));
}

inline std::string reason(const Result<scene::CommandReply>& reply) {
  return reply.ok() ? "done" : reply.error().reason;
}

// "made", or why a sheet of that configuration is refused and by which field.
inline std::string refused(const scene::SheetConfig& config) {
  const Result<Sheet> sheet = Sheet::create(config);
  return sheet.ok() ? "made" : sheet.error().reason + " " + sheet.error().field;
}

// Ids of the pieces, in the order of Sheet::pieces().
inline std::vector<std::int64_t> piece_ids(const Sheet& sheet) {
  std::vector<std::int64_t> ids;
  for (const scene::Piece& piece : sheet.pieces()) ids.push_back(piece.birth.id);
  return ids;
}

// Steps a sheet through ticks with these commands, none of which may fail, and replays the recording of it. A copy made
// before each tick must get the same state as the sheet.
inline void expect_equal_replay(const scene::SheetConfig& config,
                                const std::vector<std::vector<scene::Command>>& ticks) {
  Sheet sheet = make(config);
  Recorder recorder;
  recorder.start(sheet.config());
  for (const std::vector<scene::Command>& commands : ticks) {
    Sheet copy = sheet;
    copy.step(commands);
    const TickReport report = sheet.step(commands);
    for (const Result<scene::CommandReply>& reply : report.replies) EXPECT_TRUE(reply.ok());
    EXPECT_EQ(copy.state_hash(), sheet.state_hash());
    recorder.append({report.tick, commands, sheet.state_hash()});
  }
  const Result<ReplayReport> report = replay(recorder.recording());
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->ticks, static_cast<std::int64_t>(ticks.size()));
  EXPECT_FALSE(report->divergence);
}

inline scene::Constraint hold(scene::Region region) {
  scene::Constraint constraint;
  constraint.region = std::move(region);
  return constraint;
}

// Free, and made of these triangles.
inline scene::SheetConfig of_arrays(const mesh::IndexedMesh& sheet) {
  scene::SheetConfig config = scenes::hanging(4);
  config.mesh = scene::ArraySource{sheet.rest, sheet.triangles, {}, sheet.surface};
  config.pins.clear();
  return config;
}

}  // namespace kerf::sheet
