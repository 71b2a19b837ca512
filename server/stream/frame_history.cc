#include "server/stream/frame_history.h"

#include <algorithm>
#include <string>
#include <utility>

namespace kerf::stream {

FramePick FrameHistory::pick(std::int64_t publication, const sheet::Snapshot& snapshot, const Viewed& viewed) {
  Frame& newest = frame(publication, snapshot);
  const sheet::Topology& now = *newest.quantised.topology;
  FramePick pick;
  pick.viewed = {publication, now.version};
  pick.tick = newest.quantised.tick;
  bool full_topology = false;
  if (viewed.topology_version != now.version) {
    const Topology& patch = topology(now, viewed.topology_version);
    pick.topology = patch.bytes;
    full_topology = patch.full;
  }
  const Frame* base = full_topology ? nullptr : find(viewed.publication);
  const bool comparable = base != nullptr && base != &newest && base->quantised.box == newest.quantised.box;
  pick.body = comparable ? delta(newest, *base) : keyframe(newest);
  pick.keyframe = pick.body == newest.bodies[0];
  ++counters_.taken;
  return pick;
}

FrameHistory::Frame& FrameHistory::frame(std::int64_t publication, const sheet::Snapshot& snapshot) {
  if (!frames_.empty() && frames_.back().publication == publication) return frames_.back();
  std::optional<wire::FrameBox> box;
  if (!frames_.empty()) box = frames_.back().quantised.box;
  if (frames_.size() == kFrames) frames_.pop_front();
  // What was encoded for older frames is of no use to anyone now; only their positions are.
  for (Frame& older : frames_) older.bodies.clear();
  frames_.push_back({publication, wire::quantise_frame(snapshot, box), {}});
  ++counters_.quantised;
  return frames_.back();
}

const FrameHistory::Frame* FrameHistory::find(std::int64_t publication) const {
  const auto found =
      std::find_if(frames_.begin(), frames_.end(), [&](const Frame& each) { return each.publication == publication; });
  return found == frames_.end() ? nullptr : &*found;
}

const FrameHistory::Topology& FrameHistory::topology(const sheet::Topology& topology, std::int32_t base_version) {
  if (topology_version_ != topology.version) {
    topologies_.clear();
    topology_version_ = topology.version;
  }
  const auto [entry, is_new] = topologies_.try_emplace(base_version);
  if (is_new) {
    wire::EncodedTopology encoded = wire::encode_topology(topology, base_version);
    entry->second = {std::make_shared<const std::string>(std::move(encoded.bytes)), encoded.full};
    ++counters_.topologies;
  }
  return entry->second;
}

const Bytes& FrameHistory::keyframe(Frame& frame) {
  Bytes& body = frame.bodies[0];
  if (!body) {
    body = std::make_shared<const std::string>(wire::encode_keyframe_body(frame.quantised));
    ++counters_.keyframes;
  }
  return body;
}

const Bytes& FrameHistory::delta(Frame& frame, const Frame& base) {
  const auto known = frame.bodies.find(base.publication);
  if (known != frame.bodies.end()) return known->second;
  std::optional<std::string> encoded = wire::encode_delta_body(frame.quantised, base.quantised);
  ++counters_.deltas;
  Bytes body = encoded ? std::make_shared<const std::string>(std::move(*encoded)) : keyframe(frame);
  return frame.bodies[base.publication] = std::move(body);
}

}  // namespace kerf::stream
