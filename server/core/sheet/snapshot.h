#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"

namespace kerf::sheet {

// The triangles of a sheet at one topology version. Immutable and shared: all snapshots between two cuts hold the same
// one. For every entry the version that changed it last is kept. So the patch from any version a viewer has is a
// filter: the slots with slot_versions[s] > that version, and the vertices in the same way.
struct Topology {
  std::int32_t version = 1;
  std::int32_t patchable_since = 1;  // a viewer at an older version needs the full topology (a reset came between)
  std::int32_t num_triangles = 0;    // slots with material
  std::int32_t num_pieces = 0;       // connected pieces
  std::vector<std::array<mesh::VertexId, 3>> triangles;  // a slot; CCW in material coordinates, or kNone thrice: void
  std::vector<std::int32_t> pieces;                      // a slot; 0..num_pieces-1, kNone for void
  std::vector<std::int32_t> slot_versions;               // a slot; version that last changed its triangle or piece
  Eigen::Matrix2Xd material_positions;                   // 2 x V, m
  std::vector<std::int32_t> vertex_versions;             // a vertex; version that made it or moved it in the material
};

// Run-time figures from the owner of the clock; part of a snapshot so that viewers see them. All zero offline.
struct RunStats {
  double real_time_factor = 0.0;       // -, simulated / wall time over the last second or so
  double speed = 0.0;                  // -, target of the real-time factor; 1 is live
  std::int64_t overruns = 0;           // ticks that ended after their deadline
  double slipped_s = 0.0;              // s, simulated time given up
  double tick_cpu_us = 0.0;            // us, recent mean
  std::int64_t published_unix_us = 0;  // us since 1970, when the tick ended
  std::uint64_t sheet_serial = 0;      // number among all sheets that the owner made; versions are of one sheet
  std::int32_t settings_version = 0;   // grows when pins, gravity, wind, materials, speed or run state change
  double strained_share = 0.0;         // -, of the last tick, see fem::StepStats
  std::int32_t resets = 0;             // requested by clients
  std::int32_t resets_undone = 0;      // of them, undone
  bool paused = false;
  bool sleeping = false;
  bool failed = false;  // frozen at its last good tick
};

// A sheet after one tick. Immutable.
struct Snapshot {
  std::int64_t tick = 0;
  Eigen::Matrix3Xd positions;                // 3 x V, m, world
  std::shared_ptr<const Topology> topology;  // never null; its V is that of `positions`
  RunStats stats;
  std::vector<float> strains;  // a vertex, see dominant_strains(); empty if no sink needs them
};

// Reason for which a sink gets no more snapshots.
enum class SinkEnd { kSheetDeleted, kSheetLost, kHostStopping };

// Receives snapshots. The host calls all of these from the sheet's strand: never two at once for one sheet, and they
// must not block.
class SnapshotSink {
 public:
  virtual ~SnapshotSink() = default;
  // Called after every tick; no snapshot is built while all sinks of a sheet return false.
  [[nodiscard]] virtual bool wants_snapshot() const = 0;
  // Returns true if Snapshot::strains are needed; called together with wants_snapshot().
  [[nodiscard]] virtual bool wants_strains() const { return false; }
  // Returns the number of streams to viewers that this sink feeds.
  [[nodiscard]] virtual std::int32_t num_viewers() const { return 1; }
  virtual void publish(std::shared_ptr<const Snapshot> snapshot) = 0;
  // The last call.
  virtual void ended(SinkEnd reason) = 0;
};

}  // namespace kerf::sheet
