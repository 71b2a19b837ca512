#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/recording.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/snapshot.h"
#include "server/service/host/admission.h"
#include "server/service/host/clock.h"
#include "server/service/host/command_listener.h"
#include "server/service/host/command_result.h"
#include "server/service/host/entropy.h"
#include "server/service/host/host_options.h"
#include "server/service/host/metrics.h"
#include "server/service/host/metrics_board.h"
#include "server/service/host/pace.h"
#include "server/service/host/playback.h"
#include "server/service/host/saved_states.h"
#include "server/service/host/shared_slot.h"
#include "server/service/host/sheet_share.h"
#include "server/service/host/sheet_status.h"
#include "server/service/host/stored_run.h"
#include "server/service/host/tenants.h"
#include "server/service/host/unsaved_work.h"
#include "server/service/host/vertex_budget.h"
#include "server/service/host/workers.h"

namespace kerf::host {

class SheetRunner;
class StepVisitor;

// Is the only owner of sheets, and the only class that runs them in real time. Each sheet has a strand: a queue whose
// work runs on one thread pool, one piece at a time. A tick simulates the time dt, and tick k is due at t0 + k * dt /
// speed. A late sheet catches up by at most kMaxCatchUpTicks; the remaining time is given up, counted and reported. A
// sheet at rest sleeps: it does not tick until it is changed or its scene repeats. A snapshot is built only while a
// sink wants one. All functions are thread-safe and return at once, except stop() and wait_idle().
//
// Errors, beside those named at each function: kNotFound SHEET_NOT_FOUND, kUnavailable HOST_STOPPING, and kAborted
// SHEET_DELETED for calls that were waiting when the sheet was deleted.
class Host {
 public:
  static constexpr std::int64_t kMaxCatchUpTicks = 2;
  static constexpr double kMinSpeed = 0.01;
  static constexpr double kMaxSpeed = 4.0;
  // Wall time beyond which a tick is long. status() does not wait for a long tick, and more calls may interrupt it. An
  // interrupted tick discards its integration and keeps the effect of its commands; it is repeated later. These calls
  // interrupt:
  //                               live tick    replayed tick    tick with commands of the sheet's config
  //   delete_sheet(), stop()      yes          yes              yes (the sheet freezes, and is closed)
  //   stop token of step()        yes          no               no
  //   pause(), UndoCut, Reset     if long      no               no
  static constexpr Nanoseconds kLongTick = std::chrono::milliseconds(100);
  static constexpr std::int32_t kTicksPerTurn = 4;  // Ticks of a step() call in one turn; other sheets then get theirs.
  // Limit on entries of a recording applied in one turn before a tick, and on those after it.
  static constexpr std::int32_t kEntriesPerTurn = 4;

  // `clock` and `entropy` must outlive the host.
  Host(HostOptions options, Clock& clock, Entropy& entropy);
  ~Host();  // stop()
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  // Builds a sheet, on a thread of lower priority than the workers, and starts its clock unless `paused`. `id`:
  // [a-z][a-z0-9-]{0,62}; if empty, config.sheet_id; if that is empty too, a random one. Errors, besides those of
  // Sheet::create:
  //   kAlreadyExists      SHEET_EXISTS
  //   kResourceExhausted  TOO_MANY_SHEETS, TOO_MANY_VERTICES, OUT_OF_MEMORY
  //   kResourceExhausted  TOO_MANY_VERTICES_IN_ALL, only after the build if the mesh does not declare its size
  //   kResourceExhausted  OVERLOADED unless `paused`, if running sheets need max_load already (see Admission)
  //   kResourceExhausted  TENANT_SHEETS, TENANT_VERTICES, TENANT_LOAD, see check_new_sheet()
  //   kAborted            CREATION_ABANDONED if a stop is requested before it is built
  void create_sheet(std::string id, scene::SheetConfig config, bool paused, Callback<SheetStatus> done,
                    const std::stop_token& stop = {}, RequestName<SheetStatus> request = nullptr);
  // Builds the sheet of a recording and plays the recording in real time, at the sheet's speed. The sheet does only the
  // recorded commands; others get kFailedPrecondition REPLAYING. It pauses at the end, see ReplayState. Errors of
  // create_sheet() and sheet::check_order().
  void replay(std::string id, sheet::Recording recording, bool paused, Callback<SheetStatus> done,
              const std::stop_token& stop = {});
  // Makes a sheet of the journal again: builds it, repeats its changes, and steps it up to its mark. The listener
  // receives its commands. For a host that serves no client yet. Errors of create_sheet() except OVERLOADED.
  void recover(StoredRun run, Callback<RecoveredSheet> done);
  // Lets the recovered sheets continue as they ran. Until then they stand, so that none takes time from the recovery of
  // the others.
  void start_recovered();
  // Sets what is kept of each sheet with its saved states, and in the journal. To be set before any sheet runs.
  void set_attachments(Attachments attachments);
  // Saves the state of a sheet between two ticks under a name, [a-z][a-z0-9-]{0,62}, in memory and in the journal.
  // Errors of SavedStates::add(), check_state_bytes(); kInvalidArgument STATE_ID; kFailedPrecondition REPLAYING,
  // STEPPING; kResourceExhausted OUT_OF_MEMORY.
  void save_state(const std::string& id, std::string state_id, bool overwrite, Callback<SavedStateStatus> done);
  // Brings a saved state back: mesh, motion, undo history, pins, grabs, settings, waiting commands of schedule() and
  // counts. Pause and speed stay as they are; a sleeping sheet wakes. The sheet ticks on while the state is loaded.
  // Queued commands are done on the restored sheet. RunStats::sheet_serial is another one then. A recording to
  // HostOptions::make_recording ends.
  // Errors: kNotFound STATE_NOT_FOUND; kFailedPrecondition REPLAYING, STEPPING; kResourceExhausted OUT_OF_MEMORY,
  // TOO_MANY_RESTORES if 16 states are being loaded.
  void restore_state(const std::string& id, const std::string& state_id, Callback<SheetStatus> done,
                     RequestName<SheetStatus> request = nullptr);
  // Lists the saved states of a sheet, those saved first at first.
  void states(const std::string& id, Callback<std::vector<SavedStateStatus>> done);
  // kNotFound STATE_NOT_FOUND
  void delete_state(const std::string& id, const std::string& state_id, Callback<Nothing> done);

  // Returns the recording that the sheet has kept in memory, up to its present tick. Errors of KeptRecording::until().
  void recording(const std::string& id, Callback<KeptRun> done);
  // Deletes a sheet with its states: ends its sinks (kSheetDeleted) and the calls that wait for it (kAborted). Then
  // calls `closed`; no sink or listener gets anything about this sheet afterwards. The name becomes free once `closed`
  // has returned.
  void delete_sheet(const std::string& id, Callback<Nothing> done, std::function<void()> closed = {});

  // Returns the sorted ids; sheets still being built are left out.
  [[nodiscard]] std::vector<std::string> list() const;
  // Returns the status between two ticks. During a long tick, and during a tick that follows a long one, it returns the
  // status that statuses() gives, without state hash.
  void status(const std::string& id, Callback<SheetStatus> done);
  // Returns the statuses of the sheets that exist among `ids`, in the order of `ids`. Each is as of the sheet's last
  // tick, command or change of run state. It does not wait for ticks in progress.
  [[nodiscard]] std::vector<SheetStatus> statuses(const std::vector<std::string>& ids) const;

  // Queues a command for the next tick boundary; wakes a sleeping sheet. On a paused or failed sheet the command is
  // done at once, without advancing time. `done` receives kResourceExhausted QUEUE_FULL within this call, or the
  // sheet's own errors once the command is due. scene::validate() must accept the command, as it accepts every command
  // decoded by wire. The sheet refuses any other command when it is due, but a recording of that command cannot be
  // read. `is_of_stream`: a Grab ends with a connection, whose owner calls release_grab(). If a crash comes first, the
  // grab is released as the sheet is recovered. So it is as a state is restored.
  void submit(const std::string& id, scene::Command command, Callback<CommandResult> done,
              RequestName<CommandResult> request = nullptr, bool is_of_stream = false);
  // Schedules a command for the start of tick `at_tick`, before commands queued at that time. Commands scheduled for
  // one tick run in the order in which they were scheduled. `done` receives the command's number once it is scheduled;
  // the listener receives its outcome. A sheet with a scheduled command does not fall asleep, and a Reset does not
  // cancel the command. kFailedPrecondition TICK_PAST, field "at_tick", for a tick that is not ahead;
  // kResourceExhausted TOO_MANY_SCHEDULED.
  void schedule(const std::string& id, scene::Command command, std::int64_t at_tick, Callback<std::int64_t> done,
                RequestName<std::int64_t> request = nullptr);
  // Returns the scheduled commands that still wait, sorted by tick.
  void scheduled(const std::string& id, Callback<std::vector<ScheduledCommand>> done);
  // Cancels a scheduled command: it is never done, and no listener receives it. kNotFound SCHEDULED_CUTS_NOT_FOUND for
  // a number that schedule() never returned; kFailedPrecondition SCHEDULED_CUTS_SETTLED for a command that no longer
  // waits.
  void cancel(const std::string& id, std::int64_t number, Callback<ScheduledCommand> done,
              RequestName<ScheduledCommand> request = nullptr);
  // Sets the listener, replacing the one before. From now on it receives every command done without a caller to answer:
  // those of a scene, of schedule(), of a recording being played, and a sheet's own Reset. It also receives scheduled
  // commands that are refused at their tick. Calls come in the order of the sheet, between the answers to callers. A
  // listener set after sheets exist may have missed commands.
  void set_command_listener(CommandListener listener);
  // Queues a Release of a grab even if the queue is full, for a client that has left. To be called once per grab. Does
  // nothing if the sheet is gone, or if a reset has removed the grab.
  void release_grab(const std::string& id, std::string grab_id);

  // Pauses a sheet; ends a running step() call.
  void pause(const std::string& id, Callback<SheetStatus> done);
  // Resumes a sheet. kFailedPrecondition STEPPING while a step() call runs; kResourceExhausted TENANT_LOAD.
  void resume(const std::string& id, Callback<SheetStatus> done);
  // Sets the ratio of simulated to wall time, -, kMinSpeed..kMaxSpeed; initially 1. The speed changes the deadlines
  // only: ticks compute the same at any speed, and a step() call ignores it. kInvalidArgument OUT_OF_RANGE, field
  // "speed".
  void set_speed(const std::string& id, double speed, Callback<SheetStatus> done);
  // Runs exactly `ticks` ticks of a paused sheet as fast as possible, then answers. A pause(), a Reset, the end of a
  // replay or a stop requested through `stop` ends it early, with the ticks done so far. kInvalidArgument outside
  // 1..max_step_ticks; kFailedPrecondition NOT_PAUSED, STEPPING or SHEET_FROZEN.
  void step(const std::string& id, std::int64_t ticks, Callback<SheetStatus> done, std::stop_token stop = {});
  // Does what step() does for several sheets, side by side; no id may come twice. `done` is called after the last look
  // of the visitor. Errors of step(), of a missing sheet and of the visitor's checks come before any sheet is stepped;
  // the field is that of the sheet, such as "names[2]", unless the visitor gives another. Later ones go to the visitor.
  void step_all(const std::vector<std::string>& ids, std::int64_t ticks, std::shared_ptr<StepVisitor> visitor,
                Callback<Nothing> done, std::stop_token stop = {});

  // Calls `look` between two ticks, on the sheet's strand.
  void inspect(const std::string& id, std::function<void(const sheet::Sheet&)> look, Callback<Nothing> done);

  // Adds a sink. It gets the present snapshot at once, even from a sleeping sheet, and every later one while
  // SnapshotSink::wants_snapshot() is true.
  void add_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);
  // Publishes the present snapshot to the sink once more, for instance because the sink now wants strains. Does nothing
  // if the sink was not added.
  void refresh_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);
  // Removes a sink: it gets no calls once `done` is called. Does not call ended().
  void remove_sink(const std::string& id, std::shared_ptr<sheet::SnapshotSink> sink, Callback<Nothing> done);

  [[nodiscard]] HostMetrics metrics() const;
  // Returns the load: the needs (see WorkerNeed) of running sheets and of sheets being built to run, over the number of
  // workers. -, >= 0. Above 1 the sheets cannot all keep pace.
  [[nodiscard]] double load() const;
  [[nodiscard]] const HostOptions& options() const;
  // True while there is a sheet of this id, those being built left out.
  [[nodiscard]] bool has_sheet(const std::string& id) const { return find(id) != nullptr; }
  // Returns what the sheets of a tenant take.
  [[nodiscard]] TenantUse tenant_use(const std::string& tenant) const;

  // Blocks until no work is queued or running; pending timers do not count. For tests and simulation on a clock moved
  // by hand.
  void wait_idle();

  // Stops the host: refuses new calls, answers waiting ones (kUnavailable), ends all sinks (kHostStopping) and all
  // creations, and joins the workers. Idempotent. Not from a callback.
  void stop();
  // True once stop() has closed every sheet and its recording; only threads are left to end. Callable from any thread.
  [[nodiscard]] bool has_closed_sheets() const;

 private:
  // Describes a requested sheet until it is one of `sheets_`.
  struct Creation {
    std::string id;
    std::shared_ptr<SheetShare> share;  // Null: nothing is reserved, nor the name.
    std::shared_ptr<ExpectedNeed> need;
    std::unique_ptr<Playback> playback;  // The recording that the sheet is to play; null: none.
    bool paused = false;
    Callback<SheetStatus> done;
    std::stop_token stop;
    RequestName<SheetStatus> request;
    // The sheet is not new but stored; `recovered` then gets the result instead of `done`.
    std::shared_ptr<const StoredRun> stored;
    Callback<RecoveredSheet> recovered;
  };
  struct NamedTenant {
    std::string name;
    TenantLimits limits;
  };
  static constexpr Nanoseconds kReleaseDelay = std::chrono::seconds(2);
  static constexpr Nanoseconds kMarkPeriod = std::chrono::seconds(1);
  // Time in which a stopping host still makes changes durable; the whole stop may take 8 s.
  static constexpr std::chrono::milliseconds kFlushLimit{3000};
  // Limit on sheets being built at the same time; further ones wait.
  static constexpr std::size_t kMaxBuilders = 3;
  // Limit on states being loaded or waiting for that, of all sheets.
  static constexpr std::int32_t kMaxLoads = 16;

  // Builds the sheet on a builder thread. `made`: without id, vertices and need.
  void create(std::string id, scene::SheetConfig config, Creation made);
  // Reserves the name, and as many vertices as the config declares. A sheet made again is within its tenant's limits.
  Result<std::shared_ptr<SheetShare>> reserve(const std::string& id, const scene::SheetConfig& config,
                                              const Creation& creation);
  // Takes the vertices of a sheet just built, and its need if it is to run. Errors of SheetShare::settle(),
  // check_vertices() and check_need().
  Status settle(const Creation& creation, const sheet::Sheet& built);
  // Checks whether a sheet may run at this speed; an expected need counts from then on. Error TENANT_LOAD.
  Status check_run(const std::string& id, SheetRunner& runner, double speed);
  [[nodiscard]] TenantUse use_of(const std::string& tenant) const;  // Needs mutex_ held.
  // Returns the tenant of a sheet; nothing if it has none.
  [[nodiscard]] std::optional<NamedTenant> find_tenant(const std::string& id) const;
  // Returns the tenant whose turns a sheet shares; empty for all sheets that have none.
  [[nodiscard]] std::string turns_of(const std::string& id) const;
  SharedSlip& slip_of(const std::string& id);
  Result<sheet::Sheet> build(scene::SheetConfig config, const Creation& creation);
  // Returns an error if the sheet being built is no longer wanted.
  Status check_wanted(const Creation& creation) const;
  // Builds the sheet on a builder thread, then posts begin() to a worker.
  Status build_and_hand_on(const std::shared_ptr<Creation>& creation, scene::SheetConfig config);
  // Begins the sheet and answers the creation once it is durable.
  Status begin(Creation& creation, sheet::Sheet sheet, const Workers::Strand& strand);
  // Loads the sheet of a state, on a builder thread.
  Result<sheet::Sheet> load_sheet(const SavedState& state);
  void refuse(Creation& creation, const Error& error);
  // Keeps the states that users have saved of a sheet which is made again.
  Status keep_named(const StoredRun& run, const std::shared_ptr<const scene::SheetConfig>& config);
  using Runners = std::map<std::string, std::shared_ptr<SheetRunner>>;
  // Marks the ticks of these sheets in the journal.
  void mark(const Runners& runners);
  // Marks all sheets after each kMarkPeriod.
  void plan_to_mark();
  void release(const std::string& id);
  // Schedules the return of free memory to the system after kReleaseDelay, unless it is scheduled already.
  void plan_to_release_memory();
  bool admit(const std::string& id, const std::shared_ptr<SheetRunner>& runner);
  // Runs `work` on the sheet's strand; `done` receives the error if that is impossible.
  template <typename T>
  void on_strand(const std::string& id, const Callback<T>& done, std::function<void(SheetRunner&)> work);
  [[nodiscard]] std::shared_ptr<SheetRunner> find(const std::string& id) const;
  [[nodiscard]] Status check_ticks(std::int64_t ticks) const;
  [[nodiscard]] Error missing(const std::string& id) const;

  const HostOptions options_;
  Clock& clock_;
  Entropy& entropy_;
  MetricsBoard board_;
  VertexBudget vertices_;
  SavedStates states_;
  SharedSlot<CommandListener> listener_;
  SharedSlot<Attachments> attachments_;
  SharedSlip slip_;                                                // of sheets without a tenant
  std::map<std::string, SharedSlip> tenant_slips_;                 // by tenant; guarded by mutex_
  std::map<std::string, std::weak_ptr<const SheetShare>> shares_;  // by sheet; guarded by mutex_
  UnsavedWork unsaved_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<SheetRunner>> sheets_;  // Null: being built. Guarded by mutex_.
  std::atomic<std::uint64_t> num_made_{0};
  std::atomic<std::int64_t> promised_bytes_{0};  // Memory that builders in progress may need, bytes.
  std::atomic<std::int32_t> num_loads_{0};       // States being loaded or waiting for that.
  std::atomic<bool> stopping_{false};            // Set under mutex_.
  std::atomic<bool> has_closed_sheets_{false};
  Admission admission_;                   // guarded by mutex_
  std::optional<TimerId> release_timer_;  // guarded by mutex_
  std::optional<TimerId> mark_timer_;     // guarded by mutex_
  Workers workers_;                       // Declared after everything that its threads use.
  Workers builders_;                      // Build sheets, and post them to the workers.
};

}  // namespace kerf::host
