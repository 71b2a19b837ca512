#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "server/core/sheet/checkpoint.h"
#include "server/core/sheet/cut_log.h"
#include "server/core/sheet/moving_sheet.h"
#include "server/core/sheet/scene_clock.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/stage_scope.h"
#include "server/core/sheet/topology.h"

namespace kerf::sheet {

// Connects the parts of a sheet: runs a tick, and commands that concern more than one part.
struct Sheet::Impl {
  Impl(std::shared_ptr<const InitialState> initial, IntegratorFactory make_integrator)
      : clock(initial->config), moving(initial, std::move(make_integrator)), cuts(moving.mesh().num_pieces()) {}

  // A tick (sheet_tick.cc).
  TickReport run(std::span<const scene::Command> commands, StageObserver* observer, bool advance,
                 const StopConditions& stop);
  TickReport begin_load_step();
  void drain_commands(std::span<const scene::Command> commands, StageObserver* observer, bool scheduled,
                      TickReport& report);
  // Does the scheduled commands that are due. `number`: number of the next command of the tick, for the observer; it is
  // counted up.
  void drain_schedule(StageObserver* observer, std::int32_t& number, TickReport& report);
  void advance(StageObserver* observer, const StopConditions& stop, TickReport& report);
  // Sets tick, hash and flags of the report, from the state at the end of the step.
  void fill_report(TickReport& report) const;
  [[nodiscard]] std::uint64_t state_hash() const;

  // Commands (sheet_commands.cc). Each is done as a whole, or returns an error and changes nothing.
  Result<scene::CommandReply> do_command(const scene::Command& command, const CommandContext& context);
  [[nodiscard]] scene::CommandReply plain_reply() const;  // reply to a command that has no special reply

  // Cuts (sheet_cuts.cc).
  Result<scene::CommandReply> cut(const scene::Cut& cut, const CommandContext& context);
  Result<scene::CommandReply> cut_batch(const scene::CutBatch& batch, const CommandContext& context);
  Result<std::vector<scene::CutReply>> do_cuts(std::span<const scene::Cut> wanted, bool is_batch,
                                               const CommandContext& context);
  Result<scene::CommandReply> undo_cut(const CommandContext& context);
  Result<scene::CommandReply> redo_cut(const CommandContext& context);
  // Updates everything derived from the mesh after cuts of it.
  void follow(const std::vector<DoneCut>& done, PhaseObserver* observer);
  void redo(const std::vector<DoneCut>& done, const CommandContext& context);
  void revert(const std::vector<DoneCut>& done, const CommandContext& context);
  [[nodiscard]] scene::CommandReply undo_reply(const UndoStep& step) const;

  // Resets (sheet_reset.cc).
  [[nodiscard]] std::shared_ptr<const Checkpoint> checkpoint() const;
  void restore(const Checkpoint& to);
  void reset(const scene::Reset& reset);
  void redo_reset(const UndoStep& step);
  void restart(std::int64_t number);

  SceneClock clock;
  MovingSheet moving;
  CutLog cuts;
  LazyTopology topology;
  std::int32_t topology_version = 1;
  std::int32_t settings_version = 0;
  std::int64_t beginning = 0;  // see CommandReply::beginning
  std::int64_t last_beginning = 0;
  std::optional<std::uint64_t> scene;  // scene_hash(), once it was asked for.
};

}  // namespace kerf::sheet
