#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "server/core/sheet/snapshot.h"
#include "server/service/stream/message.h"
#include "server/service/wire/frame_encoder.h"

namespace kerf::stream {

// What was computed so far, for metrics and for tests that nothing is computed in vain or twice.
struct EncodeCounters {
  std::int64_t quantised = 0;
  std::int64_t keyframes = 0;   // encoded
  std::int64_t deltas = 0;      // encoded
  std::int64_t topologies = 0;  // encoded
  std::int64_t strains = 0;     // encoded
  std::int64_t predictors = 0;  // made, once a topology that is sent to anyone
  std::int64_t taken = 0;       // frames given to subscribers

  [[nodiscard]] std::int64_t bodies() const { return keyframes + deltas; }
};

// What a subscriber has been sent so far.
struct Viewed {
  std::int64_t publication = 0;        // of its last frame; 0: none yet
  std::int32_t topology_version = -1;  // -1: none yet
  wire::Encoding encoding = wire::Encoding::kCompact;
  bool strains = false;  // wanted
};

// What a subscriber is sent next, in bytes that others may share.
struct FramePick {
  Viewed viewed;  // once this is sent
  std::int64_t tick = 0;
  bool keyframe = false;
  Bytes body;      // see wire::encode_raw_body, encode_keyframe_body, encode_delta_body
  Bytes topology;  // see wire::encode_topology; null where the subscriber's is up to date
  Bytes strains;   // see wire::encode_strains; null where none are wanted, or the snapshot has none
};

// The last few quantised frames of a sheet and everything encoded from them. A subscriber whose last frame is still
// here and has the newest one's box gets the difference to it; everyone else gets the keyframe, as does everyone who
// needs the full topology, and everyone who reads raw arrays. Equal needs are encoded once. Not thread-safe.
class FrameHistory {
 public:
  static constexpr std::size_t kFrames = 8;
  static constexpr std::size_t kTopologies = 32;  // encoded, to be kept

  // `publication` > 0 numbers the snapshots; it never falls from call to call.
  FramePick pick(std::int64_t publication, const sheet::Snapshot& snapshot, const Viewed& viewed);

  [[nodiscard]] const EncodeCounters& counters() const { return counters_; }

 private:
  struct Frame {
    std::int64_t publication = 0;
    wire::QuantisedFrame quantised;
    Bytes raw;
    Bytes keyframe;
    std::map<std::int64_t, Bytes> deltas;  // by publication of the base
    std::map<wire::Encoding, Bytes> strains;
  };
  struct Topology {
    Bytes bytes;
    bool full = false;
  };

  Frame& frame(std::int64_t publication, const sheet::Snapshot& snapshot);
  [[nodiscard]] const Frame* find(std::int64_t publication) const;
  // Of the newest frame's topology.
  const wire::Predictors& predictors();
  const Topology& topology(std::int32_t base_version, wire::Encoding encoding);
  const Bytes& keyframe(Frame& frame, wire::Encoding encoding);
  const Bytes& delta(Frame& frame, const Frame& base);
  const Bytes& strains(Frame& frame, wire::Encoding encoding);

  std::deque<Frame> frames_;  // oldest first
  // Of the newest frame's topology, as long as it stays the same:
  std::shared_ptr<const sheet::Topology> topology_;
  std::optional<wire::Predictors> predictors_;
  std::map<std::pair<wire::Encoding, std::int32_t>, Topology> topologies_;  // by encoding and base version
  EncodeCounters counters_;
};

}  // namespace kerf::stream
