#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/core/sheet/recording.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/snapshot.h"
#include "server/service/host/clock.h"
#include "server/service/host/command_answers.h"
#include "server/service/host/command_listener.h"
#include "server/service/host/command_queue.h"
#include "server/service/host/command_result.h"
#include "server/service/host/held_back.h"
#include "server/service/host/host_options.h"
#include "server/service/host/journal.h"
#include "server/service/host/metrics_board.h"
#include "server/service/host/pace.h"
#include "server/service/host/playback.h"
#include "server/service/host/run_metrics.h"
#include "server/service/host/run_recorder.h"
#include "server/service/host/saved_run.h"
#include "server/service/host/saved_states.h"
#include "server/service/host/scene_changes.h"
#include "server/service/host/shared_slot.h"
#include "server/service/host/sheet_event.h"
#include "server/service/host/sheet_journal.h"
#include "server/service/host/sheet_share.h"
#include "server/service/host/sheet_status.h"
#include "server/service/host/snapshot_sinks.h"
#include "server/service/host/stored_run.h"
#include "server/service/host/tick_clock.h"
#include "server/service/host/tick_progress.h"
#include "server/service/host/tick_scale.h"
#include "server/service/host/unsaved_work.h"
#include "server/service/host/wake_timer.h"
#include "server/service/host/workers.h"

namespace kerf::host {

// Runs one sheet in real time, on its strand. When the TickClock calls for a tick, the tick takes the commands of the
// CommandQueue. Its outcome goes to the RunRecorder, the sinks, the RunMetrics and the callers, in this order.
// Functions run on the strand unless they are said to be callable from any thread. Comments on functions of the same
// name in Host apply here.
class SheetRunner : public std::enable_shared_from_this<SheetRunner> {
 public:
  // Holds the host's objects that its runners use.
  struct Context {
    const HostOptions& options;
    Clock& clock;
    MetricsBoard& board;
    const SharedSlot<CommandListener>& listener;
    const SharedSlot<Attachments>& attachments;
    SharedSlip& slip;
    UnsavedWork& unsaved;
    const std::atomic<bool>& stopping;  // The host stops: ticks due are skipped, and close() will follow.
    // Removes a sheet that close() has ended for lack of memory, and frees its name.
    std::function<void(const std::string& id)> lost;
    std::uint64_t serial = 0;  // Number of this sheet among all that the host has made or restored.
  };

  // `vertices`: the sheet's share of the host's budget.
  SheetRunner(std::string id, sheet::Sheet sheet, Context context, Workers::Strand strand,
              std::shared_ptr<SheetShare> share);

  // Runs `work` with this runner on its strand. Calls `refuse` with the reason if the runner is closed by then or
  // memory runs out.
  void post(std::function<void(SheetRunner&)> work, std::function<void(Error)> refuse);

  // Queues a command, from any thread. On kResourceExhausted QUEUE_FULL `done` is left unmoved.
  // The same for errors of Journal::check_room().
  Status enqueue(scene::Command command, Callback<CommandResult>& done, RequestName<CommandResult> request,
                 bool is_of_stream);
  // Queues a release, from any thread, even if the queue is full.
  void release_grab(std::string grab_id);
  // Returns the last status without state hash, from any thread, after begin().
  [[nodiscard]] std::shared_ptr<const SheetStatus> last_status() const { return last_status_.get(); }
  // True if the tick in progress has taken longer than Host::kLongTick, or follows a tick that did. Callable from any
  // thread.
  [[nodiscard]] bool is_at_long_tick() const { return progress_.is_expected_long(); }
  // Posts pause() to the strand, and interrupts a long tick, which is repeated later. Callable from any thread.
  void post_pause(const Callback<SheetStatus>& done);
  // Interrupts any tick, also of a replay; callable from any thread, before close() is posted.
  void announce_close() { closing_ = true; }
  [[nodiscard]] bool is_closing() const { return closing_; }

  // Keeps changes from now on in `journal`, as those of the sheet with this number. `last_seq`: see SheetJournal.
  void keep_in(Journal& journal, std::int64_t sheet, std::int64_t last_seq);
  // `playback`: recording that the sheet is to play; may be null.
  void begin(bool paused, std::shared_ptr<sheet::RecordingSink> recording, std::unique_ptr<Playback> playback);
  void close(sheet::SinkEnd reason);
  // Repeats the changes of a sheet that begin() has just begun, paused, steps it up to its mark, and gives it its run
  // state. From then on it keeps its changes in the journal; it ticks after start_recovered(). Returns the tick of the
  // first change with another hash. kUnavailable HOST_STOPPING.
  Result<std::optional<std::int64_t>> recover(const StoredRun& run);
  void start_recovered();
  // True if a client has changed the sheet since it was made or reset, has scheduled commands, or lets it run
  // otherwise.
  [[nodiscard]] bool is_changed() const {
    const bool is_stopped = clock_.is_paused() && sheet_.tick() > 0;
    return changes_.is_changed() || !queue_.scheduled().empty() || is_stopped || clock_.pace().speed() != 1.0;
  }
  // Returns the number of the sheet in the store; callable from any thread once the sheet runs.
  [[nodiscard]] std::int64_t stored_sheet() const { return journal_.sheet(); }
  // Returns the tick of the sheet, from any thread; the last status may show an earlier one.
  [[nodiscard]] std::int64_t reached_tick() const { return reached_tick_; }
  // Stores the sheet, with the request that made it and its answer.
  void store_creation(const RequestName<SheetStatus>& request, const SheetStatus& answer);
  // Takes no more commands, deletes the sheet from the journal, and calls `done` when that is durable.
  void remove_from_journal(std::function<void(const Status&)> done);
  // Passes a result to `done` once all changes of the sheet so far are durable.
  template <typename T>
  void answer(const Callback<T>& done, Result<T> result) {
    if (!journal_.is_on()) return done(std::move(result));
    journal_.when_durable([done, result = std::move(result)](const Status& stored) {
      if (!stored.ok()) return done(stored.error());
      done(result);
    });
  }
  // Calls `work` when all changes are durable and answered, or with an error if the sheet ends before.
  void when_settled(const SheetJournal::Release& work) {
    if (journal_.is_settled()) return work(Nothing{});
    journal_.when_durable([this, work](const Status& stored) {
      if (!stored.ok()) return work(stored);
      when_settled(work);
    });
  }
  void pause();
  Status resume();
  void set_speed(double speed);
  // Returns the share of a worker that it needs, or would need, while it ticks at a speed, see WorkerNeed.
  [[nodiscard]] std::int64_t need_at(double speed) const;
  [[nodiscard]] double speed() const { return clock_.pace().speed(); }
  [[nodiscard]] bool is_paused() const { return clock_.is_paused(); }
  [[nodiscard]] SheetShare& share() const { return *share_; }
  // Called on the strand when a step call ends, with the reason if that is an error.
  using StepDone = std::function<void(SheetRunner&, const Status&)>;
  void step(std::int64_t ticks, const Callback<SheetStatus>& done, std::stop_token stop);
  // Begins a step call without ticks for `owner`, until run_reserved(). Meanwhile the sheet takes no commands and no
  // other step calls. Errors of step(); `done` is not called then.
  Status reserve_step(const void* owner, StepDone done, std::stop_token stop);
  // Runs the ticks of a reserved call; does nothing if that has ended, as by a pause.
  void run_reserved(const void* owner, std::int64_t ticks);
  Result<std::int64_t> schedule(scene::Command command, std::int64_t at_tick, const RequestName<std::int64_t>& request);
  [[nodiscard]] const std::vector<ScheduledCommand>& scheduled() const { return queue_.scheduled(); }
  Result<ScheduledCommand> cancel(std::int64_t number, const RequestName<ScheduledCommand>& request);
  void add_sink(const std::shared_ptr<sheet::SnapshotSink>& sink);
  void refresh_sink(const std::shared_ptr<sheet::SnapshotSink>& sink);
  void remove_sink(const std::shared_ptr<sheet::SnapshotSink>& sink);
  [[nodiscard]] Result<KeptRun> kept_run() const;
  // Bytes per vertex that must be free to save a sheet, or to publish a restored one; 200 and more with undo are taken.
  static constexpr std::int64_t kBytesPerSavedVertex = 1000;
  // Saved states, in sheet_runner_states.cc. kFailedPrecondition REPLAYING, STEPPING; kResourceExhausted OUT_OF_MEMORY.
  [[nodiscard]] Result<SavedState> save_state(std::string state_id) const;
  // Keeps the state in the journal, or removes it there, and then answers.
  void store_named(const std::shared_ptr<const SavedState>& state, const Callback<SavedStateStatus>& done);
  void remove_named(const std::string& state_id, const Callback<Nothing>& done);
  // Passes a list of the states to `done` once the states and removals that it shows are durable.
  void answer_states(std::vector<SavedStateStatus> states, const Callback<std::vector<SavedStateStatus>>& done);
  // Saves the sheet in the journal if it is time to.
  void save_if_due();
  // Continues from a saved run of this scene. Run state and speed stay, a sleeping sheet wakes, and a frozen one runs
  // if the saved one did. `sheet`: loaded from run.sheet. `serial`: see Context. A refusal leaves the sheet as it is.
  Status continue_from(const SavedRun& run, sheet::Sheet sheet, std::uint64_t serial,
                       const RequestName<SheetStatus>& request);
  [[nodiscard]] SheetStatus status() const;
  [[nodiscard]] const sheet::Sheet& sheet() const { return sheet_; }

 private:
  struct StepCall {
    std::int64_t remaining = 0;
    StepDone done;
    std::stop_token stop;
    const void* owner = nullptr;
    bool is_reserved = false;  // Its ticks may not begin yet.
  };

  // A tick's commands and what became of them.
  struct TickOutcome {
    explicit TickOutcome(std::vector<PendingCommand> pending) : answers(std::move(pending)) {}
    CommandAnswers answers;
    sheet::TickReport report;
    std::vector<scene::Command> commands;
    std::vector<Result<CommandResult>> results;
  };

  // Does `work`, which changes the sheet. If memory runs out in it the sheet's state is undefined, so the sheet ends.
  template <typename Work>
  void keep_or_lose(Work work) {
    try {
      work();
    } catch (const std::bad_alloc&) {
      lose();
    }
  }
  void lose();
  [[nodiscard]] Error closed_error() const;

  // Gives a change to the journal.
  void store(const SheetEvent& event, std::vector<StoredRequest> requests = {});
  void store_run_state() { store(RunEvent{clock_.is_paused(), clock_.pace().speed()}); }
  // Parts of recover().
  Status advance_to(std::int64_t tick);
  Status repeat(const SheetEvent& event, RunEvent& last);
  Status repeat_tick(const TickEvent& tick);
  Status take_over(const SavedRun& run);
  void continue_as(const RunEvent& run);
  // Releases what waited for this.
  void became_durable(SheetJournal::Kind kind, std::int64_t number);
  // Releases the grabs of streams, which have not held them since the sheet was as it is now.
  void release_stream_grabs();
  // Returns the sheet as it is, with this id.
  [[nodiscard]] SavedState make_state(std::string state_id) const;
  // Returns the state as the journal keeps it.
  [[nodiscard]] StoredState stored(std::shared_ptr<const SavedState> state) const;
  // True if repeating what the sheet did since it was saved would take too long.
  [[nodiscard]] bool is_save_due() const;

  // Commands.
  void announce_commands();
  void commands_arrived();
  // False if commands might run out of memory halfway.
  [[nodiscard]] bool has_room_for(const std::vector<PendingCommand>& queued) const;
  void refuse_for_want_of_memory(std::vector<PendingCommand>& queued);

  // The clock.
  void start_clock();
  void stop_clock();
  void wake();
  void tick_at_deadline(std::uint64_t call);
  void fall_asleep();
  // True if the scene may repeat (Scene.repeat_after_ticks): it is watched, neither paused nor playing a recording, and
  // no client has changed it.
  [[nodiscard]] bool may_repeat() const;
  void repeat_if_over();  // Wakes a sleeping sheet to repeat its scene, if the scene's time is over.

  // Ticks, in sheet_runner_tick.cc.
  //
  // Calls Sheet::step, or Sheet::apply if time stands still. Returns false if there was nothing to apply, or if the
  // tick is incomplete: interrupted, or one of a replay with more entries left.
  bool run_once(bool advance);
  // Returns false if the tick was interrupted.
  bool run_commands(bool advance, std::vector<PendingCommand> pending);
  // Returns true if the present tick is to be interrupted and repeated later.
  [[nodiscard]] bool is_interrupted() const;
  // Returns true if the present tick must end at once, even though that freezes the sheet. `polls`: number of calls
  // within the tick, this one included.
  [[nodiscard]] bool must_give_up(int polls) const;
  [[nodiscard]] TickEstimate tick_estimate() const;
  // Gives the commands of a tick to the journal, and the answers to those with a request name.
  void store_tick(TickOutcome& outcome, bool is_apply);
  void count_changes(const std::vector<PendingCommand>& pending, const std::vector<scene::Command>& commands,
                     const sheet::TickReport& report);
  [[nodiscard]] RunMetrics::Totals totals() const;
  // Plays one tick of the recording, with the applied entries before and after it. Returns false if entries are left
  // beyond the limit of one turn.
  bool play_tick();
  bool play_applied();
  bool play_entry(bool advance);  // Returns false if interrupted.
  void end_playback();
  [[nodiscard]] bool is_playing() const { return playback_ && playback_->is_playing(); }
  // Runs some ticks of the step() call.
  void take_turn();
  void finish_step(const Status& result);

  // Returns an error while the sheet plays a recording or is stepped.
  [[nodiscard]] Status check_between_runs() const;

  // Status and snapshots.
  [[nodiscard]] RunState run_state() const;
  void publish_state();
  void publish_status();
  [[nodiscard]] SheetStatus unhashed_status() const;
  [[nodiscard]] sheet::RunStats run_stats() const;
  void publish();
  void publish_to(sheet::SnapshotSink& sink);
  void show(std::shared_ptr<const sheet::Snapshot> snapshot);
  // Keeps a snapshot from the sinks until the last edit is durable, and tells them now and then that one waits.
  void hold_back(std::shared_ptr<const sheet::Snapshot> snapshot);
  void tell_unconfirmed_at(Nanoseconds time);
  void tell_unconfirmed();

  const std::string id_;
  const Context context_;
  Workers::Strand strand_;

  // The following are used by any thread.
  CommandQueue queue_;  // Its functions for scheduled commands run on the strand only.
  TickProgress progress_;
  // Number of pauses that are posted and have not run yet. If there are any, a long tick is interrupted. Pauses run on
  // the strand, so the number does not fall during a tick.
  std::atomic<int> pauses_waiting_{0};
  std::atomic<bool> closing_{false};  // Interrupts any tick.
  SharedSlot<SheetStatus> last_status_;
  std::atomic<std::int64_t> reached_tick_{0};

  // The following are used on the strand only.
  sheet::Sheet sheet_;
  TickClock clock_;
  RunMetrics metrics_;
  RunRecorder recorder_;
  std::unique_ptr<Playback> playback_;  // null: the sheet never played a recording
  SnapshotSinks sinks_;
  SheetJournal journal_;
  HeldBack<SheetStatus> held_status_;                               // For last_status_.
  HeldBack<std::shared_ptr<const sheet::Snapshot>> held_snapshot_;  // For sinks_.
  std::optional<Nanoseconds> held_since_;                           // Time of the first edit that is held back.
  WakeTimer held_timer_;
  std::shared_ptr<const sheet::Snapshot> shown_;  // The last that sinks got; null without a journal.
  SceneChanges changes_;
  std::set<std::string> stream_grabs_;  // Grabs that end with their streams; those of a sheet that was reset, too.
  TickScale tick_scale_;
  const std::shared_ptr<SheetShare> share_;
  fem::StepStats last_step_;         // Statistics of the last tick that advanced time.
  fem::FlagCounts flagged_ticks_{};  // Ticks with each flag since the sheet was made.
  std::optional<StepCall> step_call_;
  bool turn_posted_ = false;  // A take_turn() is posted.
  std::int64_t created_unix_us_ = 0;
  std::optional<std::int64_t> resimulated_from_tick_;
  UnsavedShare unsaved_;       // CPU time of the ticks since the sheet was last saved in the journal.
  Nanoseconds saving_cpu_{0};  // CPU time that saving it took the last time.
  bool is_unsaved_ = false;    // It was stepped or changed since.
  bool is_saving_ = false;     // It is being saved there.
  bool is_ending_ = false;     // The sheet is being deleted from the journal, and takes no commands.
  bool changing_ = false;      // A tick or commands are in progress.
  bool repeats_now_ = false;   // The next tick begins with a Reset by the sheet itself.
  std::optional<sheet::SinkEnd> closed_;
  std::uint64_t serial_;  // See Context; another one after each continue_from().
  // Changes of run state and speed, and ends of replays; part of RunStats::settings_version.
  std::int32_t state_changes_ = 0;
};

}  // namespace kerf::host
