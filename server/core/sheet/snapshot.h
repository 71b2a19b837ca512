#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"

namespace kerf::scene {
struct SheetMaterials;
}  // namespace kerf::scene

namespace kerf::sheet {

// The triangles of a sheet at one topology version. Immutable and shared: all snapshots between two cuts have the same
// one. Each entry has the version that changed it last. So the patch from the version that a viewer has consists of the
// slots with slot_versions[s] above that version, and of such vertices.
struct Topology {
  std::int32_t version = 1;
  std::int32_t patchable_since = 1;  // a viewer with an older version needs the full topology, since no patch leads
                                     // from there
  std::int32_t num_triangles = 0;    // slots with material
  std::int32_t num_pieces = 0;       // connected pieces
  std::vector<std::array<mesh::VertexId, 3>> triangles;  // by slot; counter-clockwise in material coordinates; three
                                                         // times kNone for void
  std::vector<std::int32_t> pieces;                      // by slot; 0..num_pieces-1, kNone for void
  std::vector<std::int32_t> regions;                     // by slot; region of the mesh, kNone for void
  std::vector<std::int32_t> slot_versions;               // by slot; version that last changed its triangle or piece
  Eigen::Matrix2Xd material_positions;                   // 2 x V, m
  std::vector<std::int32_t> vertex_versions;             // by vertex; version that made it, or moved it in material
                                                         // coordinates last
};

// Run-time figures of a sheet from its host, for viewers. All zero in runs without a host.
struct RunStats {
  double real_time_factor = 0.0;       // -, simulated time over wall time, for about the last second
  double speed = 0.0;                  // -, wanted real-time factor; 1 is real time
  std::int64_t overruns = 0;           // ticks that ended after their deadline
  double slipped_s = 0.0;              // s, time that a late sheet gave up instead of catching up
  double tick_cpu_us = 0.0;            // us, mean CPU time of recent ticks
  std::int64_t published_unix_us = 0;  // us since 1970, when the tick ended
  std::uint64_t sheet_serial = 0;      // number among all sheets of the host, another one after each return to a saved
                                       // state; versions of different serials cannot be compared
  std::int32_t settings_version = 0;   // grows when pins, gravity, wind, materials, speed or run state change
  double strained_share = 0.0;         // -, StepStats::strained_share of the last tick
  std::int64_t intersections = 0;      // after the last tick, see fem::SelfContactStats
  std::int32_t resets = 0;             // number of resets requested by clients
  std::int32_t resets_undone = 0;      // number of resets undone
  bool paused = false;
  bool sleeping = false;
  bool failed = false;  // frozen, see Sheet::frozen()
  std::int32_t unconfirmed_ms =
      0;  // ms for which changes have waited to be durable, and so are not shown; 0: none wait
};

class Sheet;

// Numbers that a reader of a sink had measured on the sheet of a snapshot.
struct Measured {
  std::uint64_t reader = 0;  // number of the reader among those of its sink
  std::vector<double> values;
};

// A sheet after one tick. Immutable once it is published.
struct Snapshot {
  std::int64_t tick = 0;
  Eigen::Matrix3Xd positions;                              // 3 x V, m, world
  std::shared_ptr<const Topology> topology;                // never null; it has as many vertices as `positions`
  std::shared_ptr<const scene::SheetMaterials> materials;  // as set at that time; null: not known
  RunStats stats;
  std::vector<float> strains;      // by vertex, see dominant_strains(); empty if no sink needs them
  std::vector<Measured> measured;  // by SnapshotSink::measure(), of all sinks
};

// The reason why a sink gets no more snapshots.
enum class SinkEnd { kSheetDeleted, kSheetLost, kHostStopping };

// Receives snapshots. The host calls all functions on the sheet's strand (its queue of work), so never two at once for
// one sheet. They must not block.
class SnapshotSink {
 public:
  virtual ~SnapshotSink() = default;
  // Called after every tick. No snapshot is made while all sinks of a sheet return false.
  [[nodiscard]] virtual bool wants_snapshot() const = 0;
  // Returns true if Snapshot::strains are needed; called together with wants_snapshot().
  [[nodiscard]] virtual bool wants_strains() const { return false; }
  // Adds to Snapshot::measured what readers want of the sheet. Called for each snapshot before it is published, unless
  // wants_snapshot() is false. The snapshot may be published later than that.
  virtual void measure(const Sheet& /*sheet*/, Snapshot& /*snapshot*/) {}
  // Returns the number of streams to viewers that this sink feeds.
  [[nodiscard]] virtual std::int32_t num_viewers() const { return 1; }
  virtual void publish(std::shared_ptr<const Snapshot> snapshot) = 0;
  // Called last; no other call follows.
  virtual void ended(SinkEnd reason) = 0;
};

}  // namespace kerf::sheet
