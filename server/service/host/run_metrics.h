#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/base/result.h"
#include "server/core/sheet/sheet.h"
#include "server/service/host/admission.h"
#include "server/service/host/command_result.h"
#include "server/service/host/metrics_board.h"
#include "server/service/host/sheet_status.h"

namespace kerf::host {

// Keeps the counts of one sheet on the metrics board of its host.
//
// Invariants:
//   1. From the first set_state() to end(), HostMetrics::sheets and the gauge of the sheet's state count it, and no
//      other gauge of states does.
//   2. The board counts for this sheet the totals of the last tick_done() or continue_from(), and its present sinks. It
//   counts the
//      sheet's need only while the sheet ticks by the clock.
// For one thread at a time.
class RunMetrics {
 public:
  // Holds counts of a sheet since it was made; they fall only at continue_from().
  struct Totals {
    std::int64_t contact_phases = 0;
    std::int64_t cuts = 0;
    std::int64_t overruns = 0;
    Nanoseconds slipped{0};
  };
  // Describes a tick that is done, or an apply() of commands.
  struct Tick {
    Nanoseconds wall{0};
    Nanoseconds cpu{0};
    bool is_by_clock = false;           // A step at a deadline: its wall time counts for the need.
    bool is_short = false;              // The tick lacked memory, which froze the sheet.
    std::optional<fem::TickCost> cost;  // Counted cost; set for a complete tick without commands only.
    Totals totals;                      // After the tick.
  };

  // `need`: estimated need of the sheet before its first tick. `board` must outlive this.
  RunMetrics(MetricsBoard& board, WorkerNeed need) : board_(board), need_(need) {}

  // Counts the sheet under `state`. Returns false if it was counted there already, or after end().
  bool set_state(RunState state);
  // False before the first set_state().
  [[nodiscard]] bool is_begun() const { return state_.has_value(); }
  // Removes the sheet and its sinks from the gauges. The last call.
  void end();

  // Counts the need of the sheet while it ticks by the clock.
  void start_ticking() { set_need(need_.value()); }
  void stop_ticking() { set_need(0); }
  void set_period(Nanoseconds period) { need_.set_period(period); }
  // Returns its need while it ticks.
  [[nodiscard]] std::int64_t need() const { return need_.value(); }
  // Returns the need that the board counts for this sheet, see WorkerNeed::value().
  [[nodiscard]] std::int64_t counted_need() const { return counted_need_; }

  void tick_done(const Tick& tick, const sheet::TickReport& report, const std::vector<Result<CommandResult>>& results);
  // The sheet is another one from here on, with these counts, which the board has seen already.
  void continue_from(const Totals& totals) { totals_ = totals; }
  void commands_refused(std::int64_t count);
  void sink_added();
  void sink_removed();
  void snapshot_built();
  void fell_asleep();
  void lost();

 private:
  void set_need(std::int64_t need);

  MetricsBoard& board_;
  WorkerNeed need_;
  // The members below are this sheet's part of the counts on the board.
  std::optional<RunState> state_;
  bool is_ended_ = false;
  std::int32_t num_sinks_ = 0;
  std::int64_t counted_need_ = 0;
  Totals totals_;
};

}  // namespace kerf::host
