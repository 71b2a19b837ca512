#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/mesh/build/mesh_import.h"
#include "server/core/sheet/sheet.h"
#include "tests/support/scenes.h"

// A test's short ways to make, step and command a sheet.
namespace kerf::sheet {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline Sheet make(SheetConfig config) {
  Result<Sheet> created = Sheet::create(std::move(config));
  if (!created.ok()) ADD_FAILURE() << created.error().message;
  return std::move(created).value();
}

inline void run(Sheet& sheet, int ticks) {
  for (int i = 0; i < ticks; ++i) sheet.step({});
}

inline Result<CommandReply> apply(Sheet& sheet, Command command) {
  const std::vector<Command> commands{std::move(command)};
  TickReport report = sheet.apply(commands);
  return std::move(report.replies.at(0));
}

inline std::string reason(const Result<CommandReply>& reply) {
  return reply.ok() ? "done" : reply.error().reason;
}

// "made", or why a sheet of that configuration is refused and by which field.
inline std::string refused(const SheetConfig& config) {
  const Result<Sheet> sheet = Sheet::create(config);
  return sheet.ok() ? "made" : sheet.error().reason + " " + sheet.error().field;
}

inline Constraint hold(Region region) {
  Constraint constraint;
  constraint.region = std::move(region);
  return constraint;
}

// Free, and made of these triangles.
inline SheetConfig of_arrays(const mesh::IndexedMesh& sheet) {
  SheetConfig config = scenes::hanging(4);
  config.mesh = ArraySource{sheet.rest, sheet.triangles, {}, sheet.surface};
  config.pins.clear();
  return config;
}

}  // namespace kerf::sheet
