#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/recording.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/snapshot.h"
#include "server/service/host/clock.h"
#include "server/service/host/entropy.h"
#include "server/service/host/metrics.h"
#include "server/service/host/playback.h"

namespace kerf::host {

struct HostOptions {
  std::int32_t workers = 2;  // threads that step sheets, 1..256
  // A worker at one tick or call for longer than this, while others wait and none is idle, is replaced by a further one
  // until that ends (see Workers). On the machine's clock, whichever the host has; >= 0; 0: others wait.
  Nanoseconds long_work = std::chrono::milliseconds(50);
  std::int32_t max_sheets = 64;  // >= 1
  // Of the workers' time, what running sheets may need before new ones are refused; -, > 0; 0: whatever they need.
  double max_load = 1.0;
  // Vertices of all sheets together, those being built, paused or at rest included; >= 1; 0: as many as may be. New
  // sheets alone are refused by it: what cuts add counts, and is never refused.
  std::int64_t max_total_vertices = 0;
  std::int32_t max_vertices_per_sheet = sheet::kMaxVertices;  // a config's own limit may be lower
  std::int32_t max_queued_commands = 64;                      // a sheet, >= 1
  std::int32_t max_scheduled_commands = 64;                   // a sheet: of schedule(), waiting for their tick, >= 1
  std::int32_t max_step_ticks = 100'000;                      // a call of step()
  // Where a new sheet's recording goes; null, or a null result: nowhere.
  std::function<std::shared_ptr<sheet::RecordingSink>(const std::string& id)> make_recording;
  // Encodes what sheets keep of their runs, see KeptRecording; null: they keep nothing.
  std::function<std::string(const sheet::RecordedTick&)> encode_tick;
  std::size_t max_recording_bytes = std::size_t{16} << 20;          // of what one sheet keeps
  sheet::IntegratorFactory make_integrator = fem::make_integrator;  // what advances the sheets
};

enum class RunState {
  kRunning,
  kPaused,
  kSleeping,  // at rest; costs nothing until something touches it
  kFailed,    // frozen at its last good tick; still served, cuttable and resettable
};

// Estimates the time of a tick by counts of the sheet as it is, scaled by the time of its ticks so far.
struct TickEstimate {
  fem::TickCost cost;   // as counted, on one core of 2024
  double scale = 1.0;   // -, > 0: time of this sheet's ticks over their counts; 1 before the first
  double budget = 0.0;  // us, a tick's period on the wall clock

  [[nodiscard]] double total_us() const { return 1e-3 * scale * cost.total(); }
  [[nodiscard]] bool fits() const { return total_us() <= budget; }
};

// A sheet as it is between two ticks.
struct SheetStatus {
  std::string id;
  RunState run_state = RunState::kRunning;
  std::int64_t tick = 0;
  std::int32_t topology_version = 0;
  std::int32_t num_vertices = 0;
  std::int32_t num_triangles = 0;  // with material
  std::int32_t pieces = 0;
  std::optional<std::uint64_t> state_hash;  // left out by statuses()
  std::int32_t viewers = 0;                 // of all sinks
  std::int64_t scene_tick = 0;              // see sheet::Sheet::scene_tick()
  sheet::RunStats stats;
  std::vector<mesh::VertexId> pinned_vertices;
  Eigen::Vector3d gravity{0.0, 0.0, 0.0};            // m/s^2, in force
  sheet::Wind wind;                                  // in force
  std::vector<fem::Material> materials;              // in force: the sheet's own, then those of config->materials
  std::shared_ptr<const sheet::SheetConfig> config;  // as created
  std::string integrator;                            // which one runs and why
  std::optional<fem::Softening> softening;           // in force, of Fidelity::kRealTime
  std::int32_t linear_iterations = 0;                // of the last tick, see fem::StepStats
  double linear_residual = 0.0;                      // -, likewise
  fem::FlagCounts flagged_ticks{};                   // since the sheet was made, resets included
  std::optional<ReplayStatus> replay;                // of a sheet that plays, or played, a recording
  TickEstimate tick_estimate;
  // Clusters that cuts made, and substeps of a tick.
  std::optional<fem::LocalInertiaStats> local_inertia;
};

// What a sheet has kept of its run: config and entries are all that a recording file has.
struct KeptRun {
  std::shared_ptr<const sheet::SheetConfig> config;
  std::string entries;  // as HostOptions::encode_tick makes them, one after another
};

struct CommandTimings {
  double queued_us = 0.0;  // from submit() to the tick boundary; 0 for a scheduled command
  double cut_us = 0.0;     // plan, apply, remesh
  double update_us = 0.0;  // model and state
  // Expected time of a tick before the commands of this boundary, and after them; see TickEstimate.
  double tick_before_us = 0.0;
  double tick_after_us = 0.0;
  double budget_us = 0.0;  // a tick's period on the wall clock
};

struct CommandResult {
  sheet::CommandReply reply;
  CommandTimings timings;
};

// Of a command that is to be done at a tick of its own.
struct Appointment {
  std::int64_t at_tick = 0;  // 0: at the next tick boundary
  std::int64_t number = 0;   // of schedule(): 1, 2, ... for each sheet; 0 for commands of a scene
};

struct WaitingCommand {
  Appointment appointment;
  sheet::Command command;
};

// What became of a command that nobody waits for, on the sheet's strand. Must not block.
using CommandListener = std::function<void(const std::string& id, const sheet::Command& command,
                                           const Result<CommandResult>& result, const Appointment& appointment)>;

// Called exactly once: on a worker thread, or from within the call for what is refused at once. Must not block.
template <typename T>
using Callback = std::function<void(Result<T>)>;

// The only owner of sheets, and the only place where they meet real time. Runs each sheet on its own strand of one
// thread pool, a tick at each absolute deadline t0 + k * dt / speed. A sheet that is late catches up by at most
// kMaxCatchUpTicks; the rest of the time is given up, counted and told. A sheet at rest gets no timer until something
// touches it. Unwatched, no snapshot is built. All functions are thread-safe and return at once, but for stop() and
// wait_idle().
//
// Errors, beside those named at each function: kNotFound SHEET_NOT_FOUND, kUnavailable HOST_STOPPING, kAborted
// SHEET_DELETED for what was waiting when the sheet was deleted.
class Host {
 public:
  static constexpr std::int64_t kMaxCatchUpTicks = 2;
  static constexpr double kMinSpeed = 0.01;
  static constexpr double kMaxSpeed = 4.0;
  // A tick that takes longer keeps no status() waiting, and pause(), an UndoCut and a Reset end it early: what it has
  // integrated is thrown away, its commands stay done, and it begins anew. So do, of any tick, delete_sheet(), stop()
  // and the end that is asked of a step() call. But none ends one with commands of the sheet's own config; of one of a
  // replay, delete_sheet() and stop() alone.
  static constexpr Nanoseconds kLongTick = std::chrono::milliseconds(100);
  static constexpr std::int32_t kTicksPerTurn = 4;    // of a step() call, before other sheets get their turn
  static constexpr std::int32_t kEntriesPerTurn = 4;  // of a recording before a tick, and after it; likewise

  // `clock` and `entropy` must outlive the host.
  Host(HostOptions options, Clock& clock, Entropy& entropy);
  ~Host();  // stop()
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  // Builds a sheet, on a thread that gives way to the workers, and starts its clock unless `paused`. `id`:
  // [a-z][a-z0-9-]{0,62}; empty: config.sheet_id, and if that is empty too, a random one. kAlreadyExists SHEET_EXISTS,
  // kResourceExhausted TOO_MANY_SHEETS, TOO_MANY_VERTICES, TOO_MANY_VERTICES_IN_ALL (of a mesh whose size is not
  // declared only once it is built) or, unless `paused`, OVERLOADED where the sheets that run need max_load (see
  // Admission), OUT_OF_MEMORY, kAborted CREATION_ABANDONED where a stop is requested before it is built, and the errors
  // of Sheet::create.
  void create_sheet(std::string id, sheet::SheetConfig config, bool paused, Callback<SheetStatus> done,
                    const std::stop_token& stop = {});
  // Builds the sheet of a recording, which then plays it: ticks at its pace, with the recorded commands in place of any
  // others (kFailedPrecondition REPLAYING), and is paused where it ends, see ReplayState. Errors of create_sheet() and
  // of sheet::check_order().
  void replay(std::string id, sheet::Recording recording, bool paused, Callback<SheetStatus> done,
              const std::stop_token& stop = {});
  // The run of a sheet up to now. kFailedPrecondition: see KeptRecording.
  void recording(const std::string& id, Callback<KeptRun> done);
  // Ends its sinks (kSheetDeleted) and what waits for it (kAborted). Then calls `closed`, from which on nothing more is
  // said of this sheet; only then its name is free for another.
  void delete_sheet(const std::string& id, Callback<Nothing> done, std::function<void()> closed = {});

  // Ids, sorted; sheets that are still being built left out.
  [[nodiscard]] std::vector<std::string> list() const;
  // As it is between two ticks; in the middle of a long one, or of one after a long one, as statuses() has it, without
  // state hash.
  void status(const std::string& id, Callback<SheetStatus> done);
  // Of those of `ids` that exist, in that order: each as it was after its last tick, command or change of run state. A
  // sheet in the middle of a long tick keeps nobody waiting.
  [[nodiscard]] std::vector<SheetStatus> statuses(const std::vector<std::string>& ids) const;

  // Queues a command for the next tick boundary; on a paused or failed sheet it is done at once, without advancing
  // time. Wakes a sleeping sheet. kResourceExhausted QUEUE_FULL at once; else what the sheet says. sheet::validate()
  // must accept the command, as it does every command that wire decodes. The sheet refuses any other at its tick, but a
  // recording of it cannot be read.
  void submit(const std::string& id, sheet::Command command, Callback<CommandResult> done);
  // The same at the start of tick `at_tick`, ahead of what is queued then; commands of one tick in the order of these
  // calls. `done` is called as soon as that is settled, with the command's number; of what comes of it the listener is
  // told. A sheet with such a command does not fall asleep; a Reset does not take it back.
  // kFailedPrecondition TICK_PAST, field "at_tick", for a tick that is not ahead; kResourceExhausted
  // TOO_MANY_SCHEDULED.
  void schedule(const std::string& id, sheet::Command command, std::int64_t at_tick, Callback<std::int64_t> done);
  // Those that wait, by tick.
  void scheduled(const std::string& id, Callback<std::vector<WaitingCommand>> done);
  // Takes one of those back: it is never done, and no listener is told of it. kNotFound SCHEDULED_CUTS_NOT_FOUND for a
  // number that was never given, kFailedPrecondition SCHEDULED_CUTS_SETTLED for one that does not wait any more.
  void cancel(const std::string& id, std::int64_t number, Callback<WaitingCommand> done);
  // Receives every command from now on that is done and has no caller to answer: those of a scene, of schedule(), of a
  // recording that plays, and a sheet's own Reset. Receives also those with a tick of their own that are refused then.
  // They come in the order of the sheet, and callers of other commands are answered between them. Replaces the listener
  // before. A listener that is set before the first sheet is created misses nothing.
  void set_command_listener(CommandListener listener);
  // Queues a release, be the queue full or not: for whoever was given the grab and goes away, once a grab. Does nothing
  // where the sheet, or with a reset the grab, is gone.
  void release_grab(const std::string& id, std::string grab_id);

  // Ends a step() call that runs.
  void pause(const std::string& id, Callback<SheetStatus> done);
  // kFailedPrecondition STEPPING while a step() call runs.
  void resume(const std::string& id, Callback<SheetStatus> done);
  // How fast simulated time goes by the wall's, -, kMinSpeed..kMaxSpeed; 1 at first. The ticks are the same; a step()
  // call takes no notice of it. kInvalidArgument OUT_OF_RANGE, field "speed".
  void set_speed(const std::string& id, double speed, Callback<SheetStatus> done);
  // Runs exactly `ticks` ticks of a paused sheet as fast as it can, and answers when they are done, or sooner with what
  // was done when a pause(), a Reset or the end of a replay ends it, or `stop` asks it to end.
  // kInvalidArgument outside 1..max_step_ticks; kFailedPrecondition NOT_PAUSED, STEPPING or SHEET_FROZEN.
  void step(const std::string& id, std::int64_t ticks, Callback<SheetStatus> done, std::stop_token stop = {});

  // Calls `look` between two ticks, on the sheet's strand.
  void inspect(const std::string& id, std::function<void(const sheet::Sheet&)> look, Callback<Nothing> done);

  // The sink gets the present snapshot at once, asleep or not, and every one after it while it wants them.
  void add_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);
  // The sink gets the present snapshot once more: it wants more of it than it did. Nothing where it was not added.
  void refresh_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);
  // When `done` is called the sink gets no more calls. No ended().
  void remove_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);

  [[nodiscard]] HostMetrics metrics() const;
  // What running sheets need over what the workers have, -, >= 0: above 1 they cannot all keep pace. See WorkerNeed.
  [[nodiscard]] double load() const;
  [[nodiscard]] const HostOptions& options() const;

  // Blocks until no work is queued or running (timers do not count). For tests and simulation on a ManualClock.
  void wait_idle();

  // Refuses new calls, answers all that wait (kUnavailable), ends all sinks (kHostStopping) and what is being built,
  // joins the workers. Idempotent. Not from a callback.
  void stop();
  // From any thread: stop() has closed every sheet, and with it what it records; only threads are left to end.
  [[nodiscard]] bool has_closed_sheets() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::host
