#pragma once

#include <string>

#include "kerf/v1/sheets.pb.h"
#include "server/service/host/host.h"

namespace kerf::api {

v1::TickEstimate encode_tick_estimate(const host::SheetStatus& status);

// Warns in a sentence where the commands of a tick have ended real time; else empty.
std::string warning_of_slower_ticks(const host::CommandTimings& timings);

}  // namespace kerf::api
