#pragma once

#include <cstdint>
#include <string>

#include "server/service/api/api.h"
#include "server/service/host/metrics.h"
#include "server/service/ws/http_server.h"

namespace kerf::ws {

// Counts connections of the gRPC port.
struct GrpcCounts {
  std::int64_t connections = 0;          // Accepted.
  std::int64_t open_connections = 0;     // Open now.
  std::int64_t refused_connections = 0;  // Closed at once, over the limit for all addresses together.
  std::int64_t refused_by_address = 0;   // Closed at once, over the limit per address.
};

// Counts recordings to disk (kerfd --record).
struct RecordingCounts {
  std::int64_t open = 0;           // Recordings of existing sheets, now.
  std::int64_t stopped = 0;        // Open recordings that are not written now, because writing fails.
  std::int64_t waiting_bytes = 0;  // Not yet written now, by all.
  std::int64_t errors = 0;         // Failed writes.
  std::int64_t bytes = 0;          // Written.
};

// Returns the page of /metrics, Prometheus text format 0.0.4. Every name starts with kerf_, or with process_ if all
// servers have it. Names end in their unit, and those of counters in _total. `watchers`: streams of both transports.
// `certificate_end_s`: end of the server's certificate, s since 1970; 0: it has none.
std::string metrics_page(const host::HostMetrics& host, const HttpCounts& http, const GrpcCounts& grpc,
                         std::int32_t watchers, const api::FrameCounts& frames, const api::PictureCounts& pictures,
                         const RecordingCounts& recordings, std::int64_t certificate_end_s, const std::string& version);

}  // namespace kerf::ws
