#pragma once

#include <functional>
#include <string>

#include "client/load/plan.h"
#include "client/load/report.h"
#include "client/load/schedule.h"
#include "server/base/result.h"

namespace kerf::load {

// Describes the progress of a run, for a line on a terminal.
struct Progress {
  std::string stage;        // "creating sheets", "warming up", "measuring", "last cuts", "deleting sheets"
  double share = 0.0;       // Share of the stage done, 0..1.
  std::int64_t frames = 0;  // Counted so far.
  std::int64_t cuts = 0;    // Answered so far.
  std::int64_t errors = 0;
};

// Runs `plan` against its running server, deletes the sheets made, and returns the results. `progress` is called some
// times a second, from this thread. `stopper` ends the run early, with the results so far. Errors: INVALID_ARGUMENT
// from check(); UNAVAILABLE if the server is not reached; the server's error if no sheet could be made.
Result<Report> run(const Plan& plan, const std::function<void(const Progress&)>& progress, Stopper& stopper);

}  // namespace kerf::load
