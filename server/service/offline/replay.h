#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "server/base/disk.h"
#include "server/base/result.h"

namespace kerf::offline {

// Names the first tick whose state differs from the recorded one.
struct Divergence {
  std::int64_t tick = 0;
  std::string recorded_hash;  // In hexadecimal, as in kerf.v1.RunResult.
  std::string replayed_hash;
};

struct ReplayReport {
  std::int64_t ticks = 0;                // Replayed.
  std::int64_t torn_bytes = 0;           // Length of an incomplete last entry, which is left out.
  std::optional<Divergence> divergence;  // Empty if every recorded tick was equal, bit for bit.
  std::string state_hash;                // Recorded after the last tick; empty if no tick was recorded.
  std::string recorded_by;               // Build that made the recording, see wire::build_name().
  std::string replayed_by;               // This build.
};

// Replays a recording file, at most 4 GiB, and compares the state hash of every tick. `begin` receives the number of
// recorded entries before the first is replayed; it may be empty. Errors: those of the file (server/base/disk.h,
// wire::decode_recording) and of sheet::replay. A divergence is no error.
Result<ReplayReport> replay(Disk& disk, const std::string& path,
                            const std::function<void(std::size_t entries)>& begin = {});

}  // namespace kerf::offline
