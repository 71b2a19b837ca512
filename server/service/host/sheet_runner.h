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

// Who is told of commands that are done. Thread-safe.
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

// One sheet in real time: its strand, queue, clockwork and sinks. What is not said to be callable from any thread runs
// on the strand; what is said of a function of the same name in Host holds here.
class SheetRunner : public std::enable_shared_from_this<SheetRunner> {
 public:
  // What the host lends to its runners.
  struct Context {
    const HostOptions& options;
    Clock& clock;
    MetricsBoard& board;
    const ListenerSlot& listener;
    SharedSlip& slip;
    const std::atomic<bool>& stopping;  // close() is on its way: what is due is not done any more
    // Forgets a sheet that close() has ended for want of memory, and its name.
    std::function<void(const std::string& id)> lost;
    std::uint64_t serial = 0;  // of all sheets that the host has made, which
  };

  // `vertices`: what the sheet has of the host's budget.
  SheetRunner(std::string id, sheet::Sheet sheet, Context context, Workers::Strand strand,
              std::shared_ptr<VertexShare> vertices);

  // Runs `work` with this runner on its strand, if it is not closed by then and memory does not run out; else `refuse`
  // with the reason.
  void post(std::function<void(SheetRunner&)> work, std::function<void(Error)> refuse);

  // From any thread. kResourceExhausted QUEUE_FULL, and `done` is not taken.
  Status enqueue(sheet::Command command, Callback<CommandResult>& done);
  // From any thread; beyond the queue's limit, too.
  void release_grab(std::string grab_id);
  // From any thread, after begin(). Without state hash.
  [[nodiscard]] std::shared_ptr<const SheetStatus> last_status() const;
  // From any thread: a tick is under way, and for longer than Host::kLongTick, or the one before took longer.
  [[nodiscard]] bool is_at_long_tick() const;
  // From any thread: pauses on the strand, where a long tick ends early for it, to be made again.
  void post_pause(const Callback<SheetStatus>& done);
  // From any thread, before close() is posted: so does any tick, a replay's included.
  void announce_close() { closing_ = true; }

  // `playback`: what the sheet is to play; may be null.
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
    Callback<CommandResult> done;  // empty: the listener receives the outcome
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
  // Does `work`, which changes the sheet; where memory runs out in it, nothing says what is left of the sheet: it ends.
  template <typename Work>
  void keep_or_lose(Work work) {
    try {
      work();
    } catch (const std::bad_alloc&) {
      lose();
    }
  }
  void lose();
  // False: commands might find no memory in the middle of what they do.
  [[nodiscard]] bool has_room_for_commands() const;
  void refuse_for_want_of_memory(std::vector<Pending>& queued);
  // One Sheet::step, or, where time stands still, Sheet::apply. False: there was nothing to apply, or a tick has not
  // come to its end, one that is played or one that was interrupted.
  bool run_once(bool advance);
  // False: the tick was interrupted.
  bool run_commands(bool advance, std::vector<Pending> pending);
  [[nodiscard]] TickEstimate tick_estimate() const;
  // Compares what a tick took, with no command in it, with what is counted of the sheet as it is.
  void note_tick_cost(Nanoseconds cpu);
  [[nodiscard]] bool goes_on() const;             // the tick under way
  [[nodiscard]] bool may_go_on(int asked) const;  // the same, whatever comes of it
  [[nodiscard]] bool is_tick_long() const;
  // One tick of the recording, with what was applied before and after it (sheet_runner_replay.cc). False: there is more
  // of that than may be done in one turn.
  bool play_tick();
  bool play_applied();
  bool play_entry(bool advance);  // false: interrupted
  void end_playback();
  [[nodiscard]] bool is_playing() const { return playback_ && playback_->is_playing(); }
  // Sets the hash of an entry that is kept or recorded.
  void record(sheet::RecordedTick& entry);
  std::vector<Pending> take_queue();
  // Those of schedule() whose tick is the next one.
  std::vector<Pending> take_due();
  // Of all commands of the tick, scheduled ones first.
  static std::vector<Result<CommandResult>> results_of(const sheet::TickReport& report,
                                                       const std::vector<Pending>& pending, Nanoseconds drained_at,
                                                       const StageTimer& timer);
  // Answers each command, or tells the listener of it, before the next one. `commands`: those of `pending`, in order.
  void answer_or_tell(const sheet::TickReport& report, const std::vector<sheet::Command>& commands,
                      const std::vector<Pending>& pending, const std::vector<Result<CommandResult>>& results,
                      Answering& answering) const;
  void count(const sheet::TickReport& report, const std::vector<Result<CommandResult>>& results, Nanoseconds wall,
             Nanoseconds cpu);
  void publish();
  void finish_step(Result<SheetStatus> result);

  // Notes what clients did to the scene: whether it may still repeat, and their resets.
  void note_changes(const std::vector<Pending>& pending, const std::vector<sheet::Command>& commands,
                    const sheet::TickReport& report);

  [[nodiscard]] bool ticks_by_clock() const;
  // Scene.repeat_after_ticks (sheet_runner_clock.cc): somebody watches, and no client has changed the scene.
  [[nodiscard]] bool may_repeat() const;
  void await_repeat();    // falling asleep
  void repeat_if_over();  // asleep: with its next tick, where its time is over
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

  fem::StepStats last_step_;         // of the last tick
  fem::FlagCounts flagged_ticks_{};  // of all

  // What a long tick ends early for. None goes away while a tick is under way.
  std::atomic<int> pauses_waiting_{0};
  std::atomic<bool> takes_back_waiting_{false};   // an UndoCut or Reset is in queue_; written with queue_mutex_ held
  std::atomic<bool> closing_{false};              // any tick does
  std::atomic<Nanoseconds> tick_began_{kNoTick};  // of the tick under way
  std::atomic<bool> was_tick_long_{false};        // the one before

  mutable std::mutex status_mutex_;
  std::shared_ptr<const SheetStatus> last_status_;  // guarded by status_mutex_

  // On the strand.
  sheet::Sheet sheet_;
  Pace pace_;
  WorkerNeed need_;
  const std::shared_ptr<VertexShare> vertices_;
  std::vector<std::shared_ptr<sheet::SnapshotSink>> sinks_;
  std::shared_ptr<sheet::RecordingSink> recording_;
  KeptRecording kept_;
  std::unique_ptr<Playback> playback_;     // null: the sheet never played a recording
  bool tick_played_ = false;               // by a play_tick() that has not come to its end
  std::vector<WaitingCommand> scheduled_;  // by tick, equal ticks in the order they came
  std::int64_t num_scheduled_ = 0;         // ever
  std::optional<StepCall> step_call_;
  bool turn_posted_ = false;  // a take_turn() is on its way
  bool changing_ = false;     // a tick or commands are under way
  std::optional<TimerId> timer_;
  std::uint64_t generation_ = 0;  // of the clockwork: a deadline of an older one means nothing
  bool paused_ = false;
  bool sleeping_ = false;
  bool is_changed_ = false;  // by a client, since the scene began
  bool repeats_now_ = false;
  std::int64_t num_timed_ticks_ = 0;  // that tick_scale_ is of
  double tick_scale_ = 0.0;           // -, see TickEstimate; 0: no tick was timed
  std::int32_t resets_ = 0;           // that clients asked for
  std::int32_t resets_undone_ = 0;
  std::optional<sheet::SinkEnd> closed_;
  std::optional<RunState> noted_state_;  // as counted on the board
  std::int32_t state_changes_ = 0;       // of run state and speed; part of the settings version
  std::int64_t contact_phases_ = 0;      // already counted
  std::int64_t cuts_ = 0;                // already counted
  std::int64_t overruns_ = 0;            // already counted
  Nanoseconds slipped_{0};               // already counted
  std::int64_t noted_need_ = 0;          // already counted
};

}  // namespace kerf::host
