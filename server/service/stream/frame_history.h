#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "server/core/sheet/snapshot.h"
#include "server/service/stream/message.h"
#include "server/service/wire/frame_encoder.h"

namespace kerf::stream {

// Counts the encodings made so far, for metrics and for tests that nothing is encoded in vain or twice.
struct EncodeCounters {
  std::int64_t quantised = 0;
  std::int64_t keyframes = 0;   // encoded
  std::int64_t deltas = 0;      // encoded
  std::int64_t topologies = 0;  // encoded
  std::int64_t strains = 0;     // encoded
  std::int64_t predictors = 0;  // Sets of predictors made: one per topology sent in compact form.
  std::int64_t taken = 0;       // Frames given to subscribers.

  [[nodiscard]] std::int64_t bodies() const { return keyframes + deltas; }
};

// Describes the last frame that a subscriber has been sent.
struct Viewed {
  std::int64_t publication = 0;        // Number of the publication shown by the last frame; 0: no frame yet.
  std::int32_t topology_version = -1;  // -1: none yet
  wire::Encoding encoding = wire::Encoding::kCompact;
  bool strains = false;  // The subscriber wants strains.
  // RunStats::sheet_serial that `topology_version` belongs to. A frame of another serial has the full topology.
  std::optional<std::uint64_t> sheet_serial = {};
};

// Holds the next frame of a subscriber, in bytes that others may share.
struct FramePick {
  Viewed viewed;  // State of the subscriber once this is sent.
  std::int64_t tick = 0;
  bool keyframe = false;
  bool begins = false;         // The sheet has another serial than the subscriber's topology, or there was none.
  Bytes body;                  // see wire::encode_raw_body, encode_keyframe_body, encode_delta_body
  Bytes topology;              // See wire::encode_topology; null if the subscriber has the present topology.
  Bytes strains;               // See wire::encode_strains; null if none are wanted, or the snapshot has none.
  std::vector<double> values;  // Measured for the subscriber, see Channel::pick().
};

// Keeps the last few quantised frames of a sheet and everything encoded from them. A subscriber gets a delta if its
// last frame is still kept and was quantised in the same box as the newest one. In all other cases it gets a keyframe,
// also if it needs the full topology or reads raw arrays. Subscribers with equal needs share one encoding. Not
// thread-safe.
class FrameHistory {
 public:
  static constexpr std::size_t kFrames = 8;       // Quantised frames kept.
  static constexpr std::size_t kTopologies = 32;  // Encoded topologies kept.

  // Returns the frame that a subscriber needs after the frame described by `viewed`. `publication`: number of
  // `snapshot`, > 0; it never falls from call to call.
  FramePick pick(std::int64_t publication, const sheet::Snapshot& snapshot, const Viewed& viewed);

  [[nodiscard]] const EncodeCounters& counters() const { return counters_; }

 private:
  struct Frame {
    std::int64_t publication = 0;
    wire::QuantisedFrame quantised;
    Bytes raw;
    Bytes keyframe;
    std::map<std::int64_t, Bytes> deltas;  // By the publication number of the base frame.
    std::map<wire::Encoding, Bytes> strains;
  };
  struct Topology {
    Bytes bytes;
    bool full = false;  // The patch holds the whole topology.
  };

  Frame& frame(std::int64_t publication, const sheet::Snapshot& snapshot);
  [[nodiscard]] const Frame* find(std::int64_t publication) const;
  // Returns the predictors of the newest frame's topology.
  const wire::Predictors& predictors();
  const Topology& topology(std::int32_t base_version, wire::Encoding encoding);
  const Bytes& keyframe(Frame& frame, wire::Encoding encoding);
  const Bytes& delta(Frame& frame, const Frame& base);
  const Bytes& strains(Frame& frame, wire::Encoding encoding);

  std::deque<Frame> frames_;  // oldest first
  // The following belong to the newest frame's topology and are kept while it stays the same.
  std::shared_ptr<const sheet::Topology> topology_;
  std::optional<wire::Predictors> predictors_;
  std::map<std::pair<wire::Encoding, std::int32_t>, Topology> topologies_;  // By encoding and base version.
  EncodeCounters counters_;
};

}  // namespace kerf::stream
