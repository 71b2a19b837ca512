#pragma once

#include <cstdint>
#include <string>

#include "server/service/api/api.h"
#include "server/service/host/metrics.h"
#include "server/service/ws/http_server.h"

namespace kerf::ws {

// Connections of the gRPC port.
struct GrpcCounts {
  std::int64_t connections = 0;          // accepted
  std::int64_t open_connections = 0;     // now
  std::int64_t refused_connections = 0;  // closed at once, over the limit of all together
  std::int64_t refused_by_address = 0;   // closed at once, over the limit of one address
};

// Recordings to disk (kerfd --record).
struct RecordingCounts {
  std::int64_t open = 0;           // now, of sheets that there are
  std::int64_t stopped = 0;        // of these: not written now, as the disk does not take them
  std::int64_t waiting_bytes = 0;  // now, not yet written, of all
  std::int64_t errors = 0;         // writes that failed
  std::int64_t bytes = 0;          // written
};

// The page of /metrics, Prometheus text format 0.0.4. Every name starts with kerf_, or with process_ where it is
// one that all servers have, and ends in its unit, counters in _total. `watchers`: streams of both transports.
std::string metrics_page(const host::HostMetrics& host, const HttpCounts& http, const GrpcCounts& grpc,
                         std::int32_t watchers, const api::FrameCounts& frames, const api::PictureCounts& pictures,
                         const RecordingCounts& recordings, const std::string& version);

}  // namespace kerf::ws
