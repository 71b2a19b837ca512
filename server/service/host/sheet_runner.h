#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "server/service/host/admission.h"
#include "server/service/host/host.h"
#include "server/service/host/kept_recording.h"
#include "server/service/host/metrics_board.h"
#include "server/service/host/pace.h"
#include "server/service/host/stage_timer.h"
#include "server/service/host/vertex_budget.h"
#include "server/service/host/workers.h"

namespace kerf::host {

// Holds the listener for commands that are done. Thread-safe.
class ListenerSlot {
 public:
  void set(CommandListener listener) {
    auto shared = std::make_shared<const CommandListener>(std::move(listener));
    const std::lock_guard lock(mutex_);
    listener_.swap(shared);
  }
  // May be null.
  [[nodiscard]] std::shared_ptr<const CommandListener> get() const {
    const std::lock_guard lock(mutex_);
    return listener_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const CommandListener> listener_;
};

// Runs one sheet in real time: its strand, queue, clock and sinks. Functions run on the strand unless they are said to
// be callable from any thread. Comments on functions of the same name in Host apply here.
class SheetRunner : public std::enable_shared_from_this<SheetRunner> {
 public:
  // Holds the host's objects that its runners use.
  struct Context {
    const HostOptions& options;
    Clock& clock;
    MetricsBoard& board;
    const ListenerSlot& listener;
    SharedSlip& slip;
    const std::atomic<bool>& stopping;  // close() will follow; ticks due are skipped.
    // Removes a sheet that close() has ended for lack of memory, and frees its name.
    std::function<void(const std::string& id)> lost;
    std::uint64_t serial = 0;  // Number of this sheet among all that the host has made.
  };

  // `vertices`: the sheet's share of the host's budget.
  SheetRunner(std::string id, sheet::Sheet sheet, Context context, Workers::Strand strand,
              std::shared_ptr<VertexShare> vertices);

  // Runs `work` with this runner on its strand. Calls `refuse` with the reason if the runner is closed by then or
  // memory runs out.
  void post(std::function<void(SheetRunner&)> work, std::function<void(Error)> refuse);

  // Queues a command, from any thread. On kResourceExhausted QUEUE_FULL `done` is left unmoved.
  Status enqueue(sheet::Command command, Callback<CommandResult>& done);
  // Queues a release, from any thread, even if the queue is full.
  void release_grab(std::string grab_id);
  // Returns the last status without state hash, from any thread, after begin().
  [[nodiscard]] std::shared_ptr<const SheetStatus> last_status() const;
  // True, from any thread, if the present tick has taken longer than Host::kLongTick, or if the one before did.
  [[nodiscard]] bool is_at_long_tick() const;
  // Pauses on the strand, from any thread; interrupts a long tick, which is repeated later.
  void post_pause(const Callback<SheetStatus>& done);
  // Interrupts any tick, also of a replay; callable from any thread, before close() is posted.
  void announce_close() { closing_ = true; }

  // `playback`: recording that the sheet is to play; may be null.
  void begin(bool paused, std::shared_ptr<sheet::RecordingSink> recording, std::unique_ptr<Playback> playback);
  void close(sheet::SinkEnd reason);
  void pause();
  Status resume();
  void set_speed(double speed);
  void step(std::int64_t ticks, Callback<SheetStatus> done, std::stop_token stop);
  Result<std::int64_t> schedule(sheet::Command command, std::int64_t at_tick);
  [[nodiscard]] const std::vector<WaitingCommand>& scheduled() const { return scheduled_; }
  Result<WaitingCommand> cancel(std::int64_t number);
  void add_sink(std::shared_ptr<sheet::SnapshotSink> sink);
  void refresh_sink(const std::shared_ptr<sheet::SnapshotSink>& sink);
  void remove_sink(const std::shared_ptr<sheet::SnapshotSink>& sink);
  [[nodiscard]] Result<KeptRun> kept_run() const;
  [[nodiscard]] SheetStatus status() const;
  [[nodiscard]] const sheet::Sheet& sheet() const { return sheet_; }

 private:
  static constexpr Nanoseconds kNoTick = Nanoseconds::max();

  struct Pending {
    sheet::Command command;
    Callback<CommandResult> done;  // Empty if the listener gets the outcome instead.
    Nanoseconds queued_at{0};
    Appointment appointment{};
    bool is_repeat = false;  // the sheet's own Reset
  };
  class Answering;
  struct StepCall {
    std::int64_t remaining = 0;
    Callback<SheetStatus> done;
    std::stop_token stop;
  };

  void push(sheet::Command command, Callback<CommandResult> done);  // queue_mutex_ held
  void announce_commands();
  void commands_arrived();
  void on_deadline(std::uint64_t generation);
  void tick_at_deadline(std::uint64_t generation);
  void take_turn();
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
  // False if commands might run out of memory halfway.
  [[nodiscard]] bool has_room_for_commands() const;
  void refuse_for_want_of_memory(std::vector<Pending>& queued);
  // Calls Sheet::step, or Sheet::apply if time stands still. Returns false if there was nothing to apply, or if the
  // tick is incomplete: interrupted, or one of a replay with more entries left.
  bool run_once(bool advance);
  // Returns false if the tick was interrupted.
  bool run_commands(bool advance, std::vector<Pending> pending);
  [[nodiscard]] TickEstimate tick_estimate() const;
  // Compares the time of a tick without commands with the counted cost of the present sheet.
  void note_tick_cost(Nanoseconds cpu);
  // Returns false if the present tick is to be interrupted and repeated later.
  [[nodiscard]] bool goes_on() const;
  // Returns false if the present tick must end at once, even though that freezes the sheet. `asked`: number of the call
  // within the tick, from 1.
  [[nodiscard]] bool may_go_on(int asked) const;
  [[nodiscard]] bool is_tick_long() const;
  // Plays one tick of the recording, with the applied entries before and after it (sheet_runner_replay.cc). Returns
  // false if entries are left beyond the limit of one turn.
  bool play_tick();
  bool play_applied();
  bool play_entry(bool advance);  // Returns false if interrupted.
  void end_playback();
  [[nodiscard]] bool is_playing() const { return playback_ && playback_->is_playing(); }
  // Sets the hash of an entry and stores it, if it is kept or recorded.
  void record(sheet::RecordedTick& entry);
  std::vector<Pending> take_queue();
  // Removes the scheduled commands due at the next tick and returns them.
  std::vector<Pending> take_due();
  // Returns the results of all commands of the tick, scheduled ones first.
  static std::vector<Result<CommandResult>> results_of(const sheet::TickReport& report,
                                                       const std::vector<Pending>& pending, Nanoseconds drained_at,
                                                       const StageTimer& timer);
  // Answers each command, or passes it to the listener, before the next one. `commands`: those of `pending`, in order.
  void answer_or_tell(const sheet::TickReport& report, const std::vector<sheet::Command>& commands,
                      const std::vector<Pending>& pending, const std::vector<Result<CommandResult>>& results,
                      Answering& answering) const;
  void count(const sheet::TickReport& report, const std::vector<Result<CommandResult>>& results, Nanoseconds wall,
             Nanoseconds cpu);
  void publish();
  void finish_step(Result<SheetStatus> result);

  // Notes the clients' changes to the scene: whether it may still repeat, and their resets.
  void note_changes(const std::vector<Pending>& pending, const std::vector<sheet::Command>& commands,
                    const sheet::TickReport& report);

  [[nodiscard]] bool ticks_by_clock() const;
  // True if the scene may repeat (Scene.repeat_after_ticks): it is watched, and no client has changed it. See
  // sheet_runner_clock.cc.
  [[nodiscard]] bool may_repeat() const;
  void await_repeat();    // When falling asleep.
  void repeat_if_over();  // When asleep: repeats with the next tick, if its time is over.
  void wake();
  void start_clock();
  void stop_clock();
  void schedule();
  std::function<void()> deadline_call();
  void note_need(std::int64_t need);
  void note_state();
  void note_status();
  [[nodiscard]] SheetStatus unhashed_status() const;
  [[nodiscard]] RunState run_state() const;
  void publish_to(sheet::SnapshotSink& sink);
  [[nodiscard]] sheet::RunStats run_stats() const;
  [[nodiscard]] Error closed_error() const;

  const std::string id_;
  const Context context_;
  Workers::Strand strand_;

  std::mutex queue_mutex_;
  std::vector<Pending> queue_;  // guarded by queue_mutex_

  fem::StepStats last_step_;         // For the last tick.
  fem::FlagCounts flagged_ticks_{};  // For all ticks.

  // Requests that interrupt a long tick; none is withdrawn while a tick is in progress.
  std::atomic<int> pauses_waiting_{0};
  std::atomic<bool> takes_back_waiting_{false};   // An UndoCut or Reset is in queue_; written with queue_mutex_ held.
  std::atomic<bool> closing_{false};              // Interrupts any tick.
  std::atomic<Nanoseconds> tick_began_{kNoTick};  // Start of the tick in progress.
  std::atomic<bool> was_tick_long_{false};        // The tick before was long.

  mutable std::mutex status_mutex_;
  std::shared_ptr<const SheetStatus> last_status_;  // guarded by status_mutex_

  // The following are used on the strand only.
  sheet::Sheet sheet_;
  Pace pace_;
  WorkerNeed need_;
  const std::shared_ptr<VertexShare> vertices_;
  std::vector<std::shared_ptr<sheet::SnapshotSink>> sinks_;
  std::shared_ptr<sheet::RecordingSink> recording_;
  KeptRecording kept_;
  std::unique_ptr<Playback> playback_;     // null: the sheet never played a recording
  bool tick_played_ = false;               // The tick is done, but not the entries applied after it.
  std::vector<WaitingCommand> scheduled_;  // by tick, equal ticks in the order they came
  std::int64_t num_scheduled_ = 0;         // Total so far.
  std::optional<StepCall> step_call_;
  bool turn_posted_ = false;  // A take_turn() is posted.
  bool changing_ = false;     // A tick or commands are in progress.
  std::optional<TimerId> timer_;
  std::uint64_t generation_ = 0;  // Generation of the timer: deadlines of older ones are ignored.
  bool paused_ = false;
  bool sleeping_ = false;
  bool is_changed_ = false;  // Changed by a client since the scene began.
  bool repeats_now_ = false;
  std::int64_t num_timed_ticks_ = 0;  // Number of ticks in tick_scale_.
  double tick_scale_ = 0.0;           // -, see TickEstimate; 0: no tick was timed
  std::int32_t resets_ = 0;           // Resets by clients, redone ones included.
  std::int32_t resets_undone_ = 0;
  std::optional<sheet::SinkEnd> closed_;
  std::optional<RunState> noted_state_;  // As counted on the board.
  std::int32_t state_changes_ = 0;       // Run state, speed, end of replay; in the settings version.
  std::int64_t contact_phases_ = 0;      // already counted
  std::int64_t cuts_ = 0;                // already counted
  std::int64_t overruns_ = 0;            // already counted
  Nanoseconds slipped_{0};               // already counted
  std::int64_t noted_need_ = 0;          // already counted
};

}  // namespace kerf::host
