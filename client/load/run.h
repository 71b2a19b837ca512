#pragma once

#include <functional>
#include <string>

#include "client/load/plan.h"
#include "client/load/report.h"
#include "client/load/schedule.h"
#include "server/base/result.h"

namespace kerf::load {

// How far a run is, for a line on a terminal.
struct Progress {
  std::string stage;        // "making sheets", "warming up", "measuring", "last cuts", "taking down"
  double share = 0.0;       // of that stage, 0..1
  std::int64_t frames = 0;  // counted so far
  std::int64_t cuts = 0;    // answered so far
  std::int64_t errors = 0;
};

// Does what `plan` says against its server, which must be running, deletes what it made, and tells what it found.
// `progress` is called some times a second, from this thread. `stopper` ends the run early, with what there is by
// then. INVALID_ARGUMENT of check(); UNAVAILABLE where the server is not reached; the server's refusals of the first
// sheet.
Result<Report> run(const Plan& plan, const std::function<void(const Progress&)>& progress, Stopper& stopper);

}  // namespace kerf::load
