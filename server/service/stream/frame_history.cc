#include "server/service/stream/frame_history.h"

#include <algorithm>
#include <string>
#include <utility>

namespace kerf::stream {

FramePick FrameHistory::pick(std::int64_t publication, const sheet::Snapshot& snapshot, const Viewed& viewed) {
  Frame& newest = frame(publication, snapshot);
  const std::int32_t version = topology_->version;
  FramePick pick;
  const std::uint64_t serial = newest.quantised.stats.sheet_serial;
  pick.viewed = {publication, version, viewed.encoding, viewed.strains, serial};
  pick.begins = viewed.sheet_serial != serial;
  pick.tick = newest.quantised.tick;
  bool full_topology = false;
  if (pick.begins || viewed.topology_version != version) {
    const Topology& patch = topology(pick.begins ? -1 : viewed.topology_version, viewed.encoding);
    pick.topology = patch.bytes;
    full_topology = patch.full;
  }
  const bool takes_deltas = viewed.encoding == wire::Encoding::kCompact && !full_topology;
  const Frame* base = takes_deltas ? find(viewed.publication) : nullptr;
  pick.keyframe = base == nullptr || base == &newest || base->quantised.box != newest.quantised.box;
  pick.body = pick.keyframe ? keyframe(newest, viewed.encoding) : delta(newest, *base);
  if (viewed.strains && newest.quantised.strains) pick.strains = strains(newest, viewed.encoding);
  ++counters_.taken;
  return pick;
}

FrameHistory::Frame& FrameHistory::frame(std::int64_t publication, const sheet::Snapshot& snapshot) {
  if (!frames_.empty() && frames_.back().publication == publication) return frames_.back();
  std::optional<wire::FrameBox> box;
  if (!frames_.empty()) box = frames_.back().quantised.box;
  if (frames_.size() == kFrames) frames_.pop_front();
  // Drops the encodings of older frames, because only their positions are still needed.
  for (Frame& older : frames_) {
    older.raw.reset();
    older.keyframe.reset();
    older.deltas.clear();
    older.strains.clear();
  }
  frames_.push_back({publication, wire::quantise_frame(snapshot, box), nullptr, nullptr, {}, {}});
  ++counters_.quantised;
  if (topology_ != snapshot.topology) {
    topology_ = snapshot.topology;
    predictors_.reset();
    topologies_.clear();
  }
  return frames_.back();
}

const FrameHistory::Frame* FrameHistory::find(std::int64_t publication) const {
  const auto found =
      std::find_if(frames_.begin(), frames_.end(), [&](const Frame& each) { return each.publication == publication; });
  return found == frames_.end() ? nullptr : &*found;
}

const wire::Predictors& FrameHistory::predictors() {
  if (!predictors_) {
    predictors_ = wire::make_predictors(*topology_);
    ++counters_.predictors;
  }
  return *predictors_;
}

const FrameHistory::Topology& FrameHistory::topology(std::int32_t base_version, wire::Encoding encoding) {
  // Treats versions that no patch can start from as -1, so that they share the full topology. A client may claim any
  // version, and few encodings are kept.
  if (!wire::can_patch(*topology_, base_version)) base_version = -1;
  if (const auto kept = topologies_.find({encoding, base_version}); kept != topologies_.end()) return kept->second;
  if (topologies_.size() >= kTopologies) topologies_.clear();
  wire::EncodedTopology encoded =
      wire::encode_topology(*topology_, base_version, encoding == wire::Encoding::kCompact ? &predictors() : nullptr);
  ++counters_.topologies;
  Topology made{std::make_shared<const std::string>(std::move(encoded.bytes)), encoded.full};
  if (made.full) {
    Topology& full = topologies_[{encoding, -1}];
    if (!full.bytes) full = made;
    made = full;
  }
  return topologies_[{encoding, base_version}] = made;
}

const Bytes& FrameHistory::keyframe(Frame& frame, wire::Encoding encoding) {
  const bool is_raw = encoding == wire::Encoding::kRaw;
  Bytes& body = is_raw ? frame.raw : frame.keyframe;
  if (!body) {
    body = std::make_shared<const std::string>(is_raw ? wire::encode_raw_body(frame.quantised)
                                                      : wire::encode_keyframe_body(frame.quantised, predictors()));
    ++counters_.keyframes;
  }
  return body;
}

const Bytes& FrameHistory::delta(Frame& frame, const Frame& base) {
  Bytes& body = frame.deltas[base.publication];
  if (!body) {
    body = std::make_shared<const std::string>(wire::encode_delta_body(frame.quantised, base.quantised, predictors()));
    ++counters_.deltas;
  }
  return body;
}

const Bytes& FrameHistory::strains(Frame& frame, wire::Encoding encoding) {
  Bytes& bytes = frame.strains[encoding];
  if (!bytes) {
    const bool is_raw = encoding == wire::Encoding::kRaw;
    bytes =
        std::make_shared<const std::string>(wire::encode_strains(frame.quantised, is_raw ? nullptr : &predictors()));
    ++counters_.strains;
  }
  return bytes;
}

}  // namespace kerf::stream
