#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/cpp/credentials.h"
#include "client/load/condition.h"
#include "client/load/cut_shape.h"
#include "client/load/stages.h"
#include "server/base/result.h"

namespace kerf::load {

enum class Transport { kGrpc, kWebSocket };
enum class Staged { kViewers, kSheets };  // Names the things that the stages of a run count.

// Describes a run. Ranges are checked by check().
struct Plan {
  std::string server = "127.0.0.1:50051";  // HOST:PORT of gRPC
  std::string http;                        // HOST:PORT of the viewer's port; empty: no metrics are read, no WebSocket.
  client::Secrets secrets = {};            // For both addresses: a token, keys of TLS.
  std::int64_t server_pid = 0;             // Server's process on this machine; 0: `http` gives its CPU and memory.
  std::int32_t sheets = 1;                 // 1..10,000
  std::int32_t columns = 32;               // Vertices of each, 2..1000.
  std::int32_t rows = 32;                  // Vertices of each, 2..1000.
  double tick_rate_hz = 60.0;              // 1..1000
  bool still = false;                      // Nothing moves the sheets: they fall asleep.
  std::int32_t viewers = 1;                // 0..1,000; viewer i watches sheet i modulo sheets
  double viewer_rate_hz = 0.0;             // Frame rate that viewers request, 0.001..1000; 0: every tick.
  std::int32_t slow_readers = 0;           // 0..1,000; they hold every frame for hold_s.
  double hold_s = 0.5;                     // 0.001..60
  std::int32_t stalled_readers = 0;        // 0..1,000; they take a frame, then nothing for stall_s.
  double stall_s = 12.0;                   // 0.001..3600; a server ends readers after 10
  std::int32_t image_viewers = 0;          // 0..100
  std::int32_t image_width = 640;          // Pixels, 16..4096.
  std::int32_t image_height = 360;         // Pixels, 16..4096.
  double cuts_per_second = 0.0;            // Over all sheets together, 0..1000.
  CutKind cut_kind = CutKind::kSlit;
  bool keep_cuts = false;      // Otherwise each cut is undone once it is answered, so that sheets keep their size.
  double way_ms = 0.0;         // Delay added to each direction between readers and server, 0..10,000.
  double way_kib_per_s = 0.0;  // Limit per direction of each reader's connection, 1..1e6; 0: none.
  Transport transport = Transport::kGrpc;  // For viewers, slow and stalled readers.
  double warm_up_s = 1.0;                  // Before anything is counted, 0..600.
  double duration_s = 10.0;                // Measured time, 0.1..1,800.
  std::string prefix = "load";             // Sheets are PREFIX-0, PREFIX-1 ...; [a-z][a-z0-9-]{0,40}.
  std::uint64_t seed = 1;                  // For the places of cuts.
  // Changes of the number of `staged` during the measured time; none: all are there from the beginning. Viewers open
  // and close; sheets are made before, paused, and run while they count. Set by set_stages().
  std::vector<Stage> stages = {};
  Staged staged = Staged::kViewers;
  std::vector<Condition> fail_if = {};  // The run has failed if one of them holds.
};

// Sets the stages, as well as the duration and the number of viewers or sheets, which follow from them.
void set_stages(std::vector<Stage> stages, Staged staged, Plan& plan);

// Checks the ranges. INVALID_ARGUMENT with the option as its field.
[[nodiscard]] Status check(const Plan& plan);

// Returns the length (m) of a sheet's side with this many `vertices`. Edges have the same length in every grid, so that
// a larger sheet takes as many substeps per tick; 32 x 32 vertices are 1 m x 1 m.
[[nodiscard]] inline double length_m(std::int32_t vertices) {
  return (vertices - 1) / 31.0;
}

// Returns the initial number of vertices of a sheet.
[[nodiscard]] inline std::int64_t num_vertices(const Plan& plan) {
  return std::int64_t{plan.columns} * plan.rows;
}

}  // namespace kerf::load
