#pragma once

#include <string>

#include "kerf/v1/sheets.pb.h"
#include "server/service/host/host.h"

namespace kerf::api {

v1::TickEstimate encode_tick_estimate(const host::SheetStatus& status);

// Returns a one-sentence warning if the commands of a tick have made it too slow for real time; else empty.
std::string warning_of_slower_ticks(const host::CommandTimings& timings);

}  // namespace kerf::api
