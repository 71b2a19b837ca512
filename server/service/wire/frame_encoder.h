#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"
#include "server/core/sheet/snapshot.h"
#include "server/service/codec/vertex_predictors.h"
#include "server/service/wire/quantise.h"
#include "server/service/wire/stream_codec.h"

// Encodes snapshots as kerf.v1.Frame. Parts that depend on the sheet alone (body, topology) are encoded separately from
// the head, which depends on the stream. Thus many streams send the same bytes. Concatenated serialised messages read
// as one, with repeated sub-messages merged (https://protobuf.dev/programming-guides/encoding/#last-one-wins).
namespace kerf::wire {

// Holds a snapshot as integers: the content of a frame, and the reference of later deltas.
struct QuantisedFrame {
  std::int64_t tick = 0;
  FrameBox box;
  std::vector<std::uint16_t> positions;             // 3 V, in `box`.
  std::shared_ptr<const sheet::Topology> topology;  // Never null.
  sheet::RunStats stats;
  std::optional<QuantisedStrains> strains;  // Set if the snapshot has them.
};

// `current`: the box of the frame before, see choose_box().
QuantisedFrame quantise_frame(const sheet::Snapshot& snapshot, const std::optional<FrameBox>& current);

// kerf.v1.Encoding
enum class Encoding { kCompact, kRaw };

// Predictors of compact frames of one topology; made once for all of them.
using Predictors = std::vector<codec::VertexPredictor>;
Predictors make_predictors(const sheet::Topology& topology);

// Return serialised Frames without sequence, epoch, topology, strains and stats.skipped. `predictors` are those of the
// frame's topology. A delta is compact, relative to `base`, whose box must be the same.
std::string encode_raw_body(const QuantisedFrame& frame);
std::string encode_keyframe_body(const QuantisedFrame& frame, const Predictors& predictors);
std::string encode_delta_body(const QuantisedFrame& frame, const QuantisedFrame& base, const Predictors& predictors);

// Returns a serialised Frame with only the strains, which the frame must have. `predictors`: null for raw.
std::string encode_strains(const QuantisedFrame& frame, const Predictors* predictors);

// Returns a serialised Frame with only the values of probes. `columns`: names of the values; null except in a stream's
// first frame.
std::string encode_probe_values(const std::vector<double>& values, const std::vector<std::string>* columns);

// Holds a serialised Frame with only `topology`.
struct EncodedTopology {
  std::string bytes;
  bool full = false;  // TopologyPatch.base_version is -1.
};
// Returns the patch from `base_version` (-1: the viewer has nothing) to the topology's own version. It lists the slots
// and vertices changed by any version in between. It is full if the history does not reach back that far, or if the
// list would be about as large. `predictors`: null for raw, else of `topology`.
EncodedTopology encode_topology(const sheet::Topology& topology, std::int32_t base_version,
                                const Predictors* predictors);
// True if the history of `topology` reaches back to `base_version`; else the patch is full.
bool can_patch(const sheet::Topology& topology, std::int32_t base_version);

// Returns the start of a serialised WatchResponse with a frame; `rest_bytes` more bytes (body, topology, strains and
// values) must follow. sequence >= 1; skipped >= 0, in ticks; epoch: empty except in a stream's first frame.
std::string encode_frame_head(std::int64_t sequence, std::int64_t skipped, std::string_view epoch,
                              std::size_t rest_bytes);

// Return complete serialised WatchResponses.
std::string encode_ended(EndReason reason);
std::string encode_rejection(std::string_view grab_id, const Error& error);

}  // namespace kerf::wire
