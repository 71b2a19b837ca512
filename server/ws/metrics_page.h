#pragma once

#include <cstdint>
#include <string>

#include "server/api/api.h"
#include "server/host/metrics.h"
#include "server/ws/http_server.h"

namespace kerf::ws {

// The page of /metrics, Prometheus text format 0.0.4. Every name starts with kerf_, or with process_ where it is
// one that all servers have, and ends in its unit, counters in _total. `watchers`: streams of both transports.
std::string metrics_page(const host::HostMetrics& host, const HttpCounts& http, std::int32_t watchers,
                         const api::FrameCounts& frames, const api::PictureCounts& pictures,
                         const std::string& version);

}  // namespace kerf::ws
