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
#include "server/core/fem/step/integrator.h"
#include "server/core/fem/step/softening.h"
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
  std::int32_t workers = 2;  // Threads that step sheets, 1..256.
  // Time after which a worker busy with one tick or call is replaced by a further thread (see Workers). That happens
  // only if others wait and none is idle. Measured on the machine's clock, whichever clock the host has. >= 0; 0:
  // no worker is replaced, so others wait.
  Nanoseconds long_work = std::chrono::milliseconds(50);
  std::int32_t max_sheets = 64;  // >= 1
  // Load from which new running sheets are refused, see Admission; -, > 0; 0: no limit.
  double max_load = 1.0;
  // Limit on the vertices of all sheets together, those being built, paused or at rest included; >= 1; 0: none. It
  // refuses new sheets only: vertices added by cuts count, but are never refused.
  std::int64_t max_total_vertices = 0;
  std::int32_t max_vertices_per_sheet = sheet::kMaxVertices;  // A config's own limit may be lower.
  std::int32_t max_queued_commands = 64;                      // Per sheet, >= 1.
  std::int32_t max_scheduled_commands = 64;  // Per sheet: commands of schedule() that wait for their tick, >= 1.
  std::int32_t max_step_ticks = 100'000;     // Per call of step().
  // Returns the destination of a new sheet's recording; null, or a null result: it is not recorded.
  std::function<std::shared_ptr<sheet::RecordingSink>(const std::string& id)> make_recording;
  // Encodes the ticks that sheets keep of their runs, see KeptRecording; null: they keep nothing.
  std::function<std::string(const sheet::RecordedTick&)> encode_tick;
  std::size_t max_recording_bytes = std::size_t{16} << 20;          // Per sheet, of the kept ticks.
  sheet::IntegratorFactory make_integrator = fem::make_integrator;  // Makes the integrators of the sheets.
};

enum class RunState {
  kRunning,
  kPaused,
  kSleeping,  // At rest; uses no processor time until it is changed.
  kFailed,    // Frozen at its last good tick; still served, cuttable and resettable.
};

// Estimates the time of a tick from operation counts of the present sheet, scaled by the measured time of its ticks.
struct TickEstimate {
  fem::TickCost cost;   // Counted for one core of 2024.
  double scale = 1.0;   // -, > 0: measured time of this sheet's ticks over the counted one; 1 before the first.
  double budget = 0.0;  // us, period of a tick on the wall clock.

  [[nodiscard]] double total_us() const { return 1e-3 * scale * cost.total(); }
  [[nodiscard]] bool fits() const { return total_us() <= budget; }
};

// Describes a sheet between two ticks.
struct SheetStatus {
  std::string id;
  RunState run_state = RunState::kRunning;
  std::int64_t tick = 0;
  std::int32_t topology_version = 0;
  std::int32_t num_vertices = 0;
  std::int32_t num_triangles = 0;  // with material
  std::int32_t pieces = 0;
  std::optional<std::uint64_t> state_hash;  // Left out by statuses().
  std::int32_t viewers = 0;                 // Summed over all sinks.
  std::int64_t scene_tick = 0;              // see sheet::Sheet::scene_tick()
  sheet::RunStats stats;
  std::vector<mesh::VertexId> pinned_vertices;
  Eigen::Vector3d gravity{0.0, 0.0, 0.0};            // m/s^2, in force
  sheet::Wind wind;                                  // in force
  std::vector<fem::Material> materials;              // In force: the sheet's own, then those of config->materials.
  std::shared_ptr<const sheet::SheetConfig> config;  // as created
  std::string integrator;                            // Names the integrator in use and the reason for it.
  std::optional<fem::Softening> softening;           // In force with Fidelity::kRealTime.
  std::int32_t linear_iterations = 0;                // In the last tick, see fem::StepStats.
  double linear_residual = 0.0;                      // -, in the last tick.
  fem::FlagCounts flagged_ticks{};                   // Since the sheet was made, resets included.
  std::optional<ReplayStatus> replay;                // Set for a sheet that plays, or played, a recording.
  TickEstimate tick_estimate;
  // Clusters made by cuts, and substeps of a tick.
  std::optional<fem::LocalInertiaStats> local_inertia;
};

// Holds the kept run of a sheet: config and entries are the whole content of a recording file.
struct KeptRun {
  std::shared_ptr<const sheet::SheetConfig> config;
  std::string entries;  // Results of HostOptions::encode_tick, concatenated.
};

struct CommandTimings {
  double queued_us = 0.0;  // From submit() to the tick boundary; 0 for a scheduled command.
  double cut_us = 0.0;     // Plan, apply, remesh.
  double update_us = 0.0;  // Update of model and state.
  // Expected time of a tick before and after the commands of this boundary; see TickEstimate.
  double tick_before_us = 0.0;
  double tick_after_us = 0.0;
  double budget_us = 0.0;  // a tick's period on the wall clock
};

struct CommandResult {
  sheet::CommandReply reply;
  CommandTimings timings;
};

// Identifies a command that is scheduled for a tick.
struct Appointment {
  std::int64_t at_tick = 0;  // 0: at the next tick boundary.
  std::int64_t number = 0;   // Number of the call of schedule(): 1, 2, ... per sheet; 0 for commands of a scene.
};

struct WaitingCommand {
  Appointment appointment;
  sheet::Command command;
};

// Receives the outcome of a command that has no caller to answer, on the sheet's strand. Must not block.
using CommandListener = std::function<void(const std::string& id, const sheet::Command& command,
                                           const Result<CommandResult>& result, const Appointment& appointment)>;

// Called exactly once: on a worker thread, or within the call if it is refused at once. Must not block.
template <typename T>
using Callback = std::function<void(Result<T>)>;

// Is the only owner of sheets, and the only class that runs them in real time. Each sheet has its own strand of one
// thread pool and ticks at the absolute deadlines t0 + k * dt / speed. A late sheet catches up by at most
// kMaxCatchUpTicks; the remaining time is given up, counted and reported. A sheet at rest has no timer until it is
// changed. Without viewers no snapshot is built. All functions are thread-safe and return at once, except stop() and
// wait_idle().
//
// Errors, beside those named at each function: kNotFound SHEET_NOT_FOUND, kUnavailable HOST_STOPPING, and kAborted
// SHEET_DELETED for calls that were waiting when the sheet was deleted.
class Host {
 public:
  static constexpr std::int64_t kMaxCatchUpTicks = 2;
  static constexpr double kMinSpeed = 0.01;
  static constexpr double kMaxSpeed = 4.0;
  // Ticks that take longer are long: status() does not wait for them, and more calls may interrupt them. An interrupted
  // tick discards its integration, keeps the effect of its commands, and starts again. These calls interrupt:
  //                               live tick    replayed tick    tick with commands of the sheet's config
  //   delete_sheet(), stop()      yes          yes              yes (the sheet freezes, and is closed)
  //   stop token of step()        yes          no               no
  //   pause(), UndoCut, Reset     if long      no               no
  static constexpr Nanoseconds kLongTick = std::chrono::milliseconds(100);
  static constexpr std::int32_t kTicksPerTurn = 4;  // Ticks of a step() call before other sheets get their turn.
  // Entries of a recording before a tick, and as many after it, before other sheets get their turn.
  static constexpr std::int32_t kEntriesPerTurn = 4;

  // `clock` and `entropy` must outlive the host.
  Host(HostOptions options, Clock& clock, Entropy& entropy);
  ~Host();  // stop()
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  // Builds a sheet, on a thread of lower priority than the workers, and starts its clock unless `paused`. `id`:
  // [a-z][a-z0-9-]{0,62}; if empty, config.sheet_id; if that is empty too, a random one. Errors, besides those of
  // Sheet::create:
  //   kAlreadyExists SHEET_EXISTS
  //   kResourceExhausted TOO_MANY_SHEETS, TOO_MANY_VERTICES, OUT_OF_MEMORY
  //   kResourceExhausted TOO_MANY_VERTICES_IN_ALL, only after the build if the mesh does not declare its size
  //   kResourceExhausted OVERLOADED unless `paused`, if running sheets need max_load already (see Admission)
  //   kAborted CREATION_ABANDONED if a stop is requested before it is built
  void create_sheet(std::string id, sheet::SheetConfig config, bool paused, Callback<SheetStatus> done,
                    const std::stop_token& stop = {});
  // Builds the sheet of a recording and plays it at its pace. It performs only the recorded commands (others get
  // kFailedPrecondition REPLAYING) and pauses at the end, see ReplayState. Errors of create_sheet() and
  // sheet::check_order().
  void replay(std::string id, sheet::Recording recording, bool paused, Callback<SheetStatus> done,
              const std::stop_token& stop = {});
  // Returns the run of a sheet up to now. kFailedPrecondition: see KeptRecording.
  void recording(const std::string& id, Callback<KeptRun> done);
  // Deletes a sheet: ends its sinks (kSheetDeleted) and the calls that wait for it (kAborted). Then calls `closed`; no
  // sink or listener gets anything about this sheet afterwards. Its name becomes free after that.
  void delete_sheet(const std::string& id, Callback<Nothing> done, std::function<void()> closed = {});

  // Returns the sorted ids; sheets still being built are left out.
  [[nodiscard]] std::vector<std::string> list() const;
  // Returns the status between two ticks. During a long tick, or one after a long one, it returns that of statuses(),
  // without state hash.
  void status(const std::string& id, Callback<SheetStatus> done);
  // Returns the status of those `ids` that exist, in that order. Each is as of the sheet's last tick, command or change
  // of run state. It does not wait for sheets in the middle of a long tick.
  [[nodiscard]] std::vector<SheetStatus> statuses(const std::vector<std::string>& ids) const;

  // Queues a command for the next tick boundary; wakes a sleeping sheet. On a paused or failed sheet it is done at
  // once, without advancing time. kResourceExhausted QUEUE_FULL at once; otherwise the sheet's errors.
  // sheet::validate() must accept the command, as it does every command decoded by wire. The sheet refuses any other at
  // its tick, but a recording of it cannot be read.
  void submit(const std::string& id, sheet::Command command, Callback<CommandResult> done);
  // Schedules a command for the start of tick `at_tick`, before commands queued then. Commands of one tick run in the
  // order of these calls. `done` receives the command's number once it is scheduled; the listener receives its outcome.
  // A sheet with such a command does not fall asleep, and a Reset does not cancel it. kFailedPrecondition TICK_PAST,
  // field "at_tick", for a tick that is not ahead; kResourceExhausted TOO_MANY_SCHEDULED.
  void schedule(const std::string& id, sheet::Command command, std::int64_t at_tick, Callback<std::int64_t> done);
  // Returns the scheduled commands that still wait, by tick.
  void scheduled(const std::string& id, Callback<std::vector<WaitingCommand>> done);
  // Cancels a scheduled command: it is never done, and no listener receives it. kNotFound SCHEDULED_CUTS_NOT_FOUND for
  // a number never given; kFailedPrecondition SCHEDULED_CUTS_SETTLED for a command that no longer waits.
  void cancel(const std::string& id, std::int64_t number, Callback<WaitingCommand> done);
  // Sets the listener, replacing the one before. From now on it receives every command done without a caller to answer:
  // those of a scene, of schedule(), of a recording being played, and a sheet's own Reset. It also receives scheduled
  // commands that are refused at their tick. Calls come in the order of the sheet, between the answers to callers. Set
  // it before any sheet exists, and it misses nothing.
  void set_command_listener(CommandListener listener);
  // Queues a release even if the queue is full, for a client that goes away; once per grab. Does nothing if the sheet
  // is gone, or if a reset has removed the grab.
  void release_grab(const std::string& id, std::string grab_id);

  // Pauses a sheet; ends a running step() call.
  void pause(const std::string& id, Callback<SheetStatus> done);
  // Resumes a sheet. kFailedPrecondition STEPPING while a step() call runs.
  void resume(const std::string& id, Callback<SheetStatus> done);
  // Sets the ratio of simulated to wall time, -, kMinSpeed..kMaxSpeed; initially 1. The ticks are the same, and a
  // step() call ignores it. kInvalidArgument OUT_OF_RANGE, field "speed".
  void set_speed(const std::string& id, double speed, Callback<SheetStatus> done);
  // Runs exactly `ticks` ticks of a paused sheet as fast as possible, then answers. A pause(), a Reset, the end of a
  // replay or a stop requested through `stop` ends it early, with the ticks done so far. kInvalidArgument outside
  // 1..max_step_ticks; kFailedPrecondition NOT_PAUSED, STEPPING or SHEET_FROZEN.
  void step(const std::string& id, std::int64_t ticks, Callback<SheetStatus> done, std::stop_token stop = {});

  // Calls `look` between two ticks, on the sheet's strand.
  void inspect(const std::string& id, std::function<void(const sheet::Sheet&)> look, Callback<Nothing> done);

  // Adds a sink. It gets the present snapshot at once, even from a sleeping sheet, and every later one while it wants
  // them.
  void add_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);
  // Publishes the present snapshot to the sink once more, because it wants more of it than before. Does nothing if the
  // sink was not added.
  void refresh_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);
  // Removes a sink: it gets no calls once `done` is called. Does not call ended().
  void remove_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);

  [[nodiscard]] HostMetrics metrics() const;
  // Returns the need of running sheets over the number of workers, -, >= 0. Above 1 they cannot all keep pace. See
  // WorkerNeed.
  [[nodiscard]] double load() const;
  [[nodiscard]] const HostOptions& options() const;

  // Blocks until no work is queued or running; pending timers do not count. For tests and simulation on a ManualClock.
  void wait_idle();

  // Stops the host: refuses new calls, answers waiting ones (kUnavailable), ends all sinks (kHostStopping) and all
  // creations, and joins the workers. Idempotent. Not from a callback.
  void stop();
  // True once stop() has closed every sheet and its recording; only threads are left to end. Callable from any thread.
  [[nodiscard]] bool has_closed_sheets() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::host
