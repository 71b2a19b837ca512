#include "server/wire/frame_encoder.h"

#include <bit>
#include <cstring>
#include <span>
#include <utility>

#include "kerf/v1/stream.pb.h"
#include "server/base/check.h"

namespace kerf::wire {
namespace {

static_assert(std::endian::native == std::endian::little, "packed arrays are copied as they lie in memory");

template <typename T>
void append_packed(T value, std::string& bytes) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

void append_triangle(const sheet::Topology& topology, std::size_t slot, v1::TopologyPatch& patch) {
  for (const mesh::VertexId vertex : topology.triangles[slot]) append_packed(vertex, *patch.mutable_triangles());
  append_packed(topology.pieces[slot], *patch.mutable_pieces());
}

void append_material_position(const sheet::Topology& topology, Eigen::Index vertex, v1::TopologyPatch& patch) {
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    append_packed(static_cast<float>(topology.material_positions(axis, vertex)), *patch.mutable_material_positions());
  }
}

// Ascending indices of the entries that a version after `base_version` changed.
std::vector<std::uint32_t> changed_since(const std::vector<std::int32_t>& versions, std::int32_t base_version) {
  std::vector<std::uint32_t> changed;
  for (std::size_t i = 0; i < versions.size(); ++i) {
    if (versions[i] > base_version) changed.push_back(static_cast<std::uint32_t>(i));
  }
  return changed;
}

void fill_full(const sheet::Topology& topology, v1::TopologyPatch& patch) {
  patch.set_base_version(-1);
  patch.mutable_triangles()->reserve(12 * topology.triangles.size());
  patch.mutable_pieces()->reserve(4 * topology.pieces.size());
  for (std::size_t slot = 0; slot < topology.triangles.size(); ++slot) append_triangle(topology, slot, patch);
  for (Eigen::Index v = 0; v < topology.material_positions.cols(); ++v) append_material_position(topology, v, patch);
}

// False, with the patch half filled, where a full one is no larger.
bool fill_union(const sheet::Topology& topology, std::int32_t base_version, v1::TopologyPatch& patch) {
  const std::vector<std::uint32_t> slots = changed_since(topology.slot_versions, base_version);
  const std::vector<std::uint32_t> vertices = changed_since(topology.vertex_versions, base_version);
  const std::size_t bytes = 20 * slots.size() + 12 * vertices.size();
  if (bytes >= 16 * topology.triangles.size() + 8 * topology.vertex_versions.size()) return false;
  patch.set_base_version(base_version);
  for (const std::uint32_t slot : slots) {
    append_packed(slot, *patch.mutable_slots());
    append_triangle(topology, slot, patch);
  }
  for (const std::uint32_t vertex : vertices) {
    append_packed(vertex, *patch.mutable_vertices());
    append_material_position(topology, static_cast<Eigen::Index>(vertex), patch);
  }
  return true;
}

void encode_stats(const QuantisedFrame& frame, v1::FrameStats& stats) {
  stats.set_real_time_factor(frame.stats.real_time_factor);
  stats.set_overruns(frame.stats.overruns);
  stats.set_slipped_s(frame.stats.slipped_s);
  stats.set_tick_cpu_us(frame.stats.tick_cpu_us);
  stats.set_published_unix_us(frame.stats.published_unix_us);
  stats.set_pieces(frame.topology->num_pieces);
  stats.set_num_triangles(frame.topology->num_triangles);
  stats.set_settings_version(frame.stats.settings_version);
  stats.set_paused(frame.stats.paused);
  stats.set_sleeping(frame.stats.sleeping);
}

std::string encode_body(const QuantisedFrame& frame, std::int64_t base_tick, std::string positions) {
  v1::Frame message;
  message.set_tick(frame.tick);
  message.set_base_tick(base_tick);
  message.set_topology_version(frame.topology->version);
  message.set_num_vertices(static_cast<std::int32_t>(frame.positions.size() / 3));
  v1::Vec3& min = *message.mutable_box()->mutable_min();
  min.set_x(frame.box.min[0]);
  min.set_y(frame.box.min[1]);
  min.set_z(frame.box.min[2]);
  v1::Vec3& max = *message.mutable_box()->mutable_max();
  max.set_x(frame.box.min[0] + frame.box.size[0]);
  max.set_y(frame.box.min[1] + frame.box.size[1]);
  max.set_z(frame.box.min[2] + frame.box.size[2]);
  message.set_positions(std::move(positions));
  encode_stats(frame, *message.mutable_stats());
  return message.SerializeAsString();
}

void append_varint(std::uint64_t value, std::string& bytes) {
  while (value >= 0x80) {
    bytes.push_back(static_cast<char>((value & 0x7f) | 0x80));
    value >>= 7;
  }
  bytes.push_back(static_cast<char>(value));
}

}  // namespace

QuantisedFrame quantise_frame(const sheet::Snapshot& snapshot, const std::optional<FrameBox>& current) {
  const std::span<const double> positions(snapshot.positions.data(),
                                          static_cast<std::size_t>(snapshot.positions.size()));
  QuantisedFrame frame;
  frame.tick = snapshot.tick;
  frame.box = choose_box(positions, current);
  frame.positions = quantise(positions, frame.box);
  frame.topology = snapshot.topology;
  frame.stats = snapshot.stats;
  return frame;
}

std::string encode_keyframe_body(const QuantisedFrame& frame) {
  return encode_body(frame, -1, encode_keyframe_positions(frame.positions));
}

std::optional<std::string> encode_delta_body(const QuantisedFrame& frame, const QuantisedFrame& base) {
  KERF_CHECK(base.box == frame.box, "a delta needs the box of its base");
  std::string positions = encode_delta_positions(frame.positions, base.positions);
  if (positions.size() >= sizeof(frame.positions[0]) * frame.positions.size()) return std::nullopt;
  return encode_body(frame, base.tick, std::move(positions));
}

EncodedTopology encode_topology(const sheet::Topology& topology, std::int32_t base_version) {
  v1::Frame message;
  v1::TopologyPatch& patch = *message.mutable_topology();
  const bool patchable = base_version >= topology.patchable_since;
  const bool full = !patchable || !fill_union(topology, base_version, patch);
  if (full) {
    patch.Clear();
    fill_full(topology, patch);
  }
  patch.set_num_slots(static_cast<std::int32_t>(topology.triangles.size()));
  patch.set_num_pieces(topology.num_pieces);
  return {message.SerializeAsString(), full};
}

std::string encode_frame_head(std::int64_t sequence, std::int64_t skipped, std::size_t rest_bytes) {
  v1::Frame own;
  own.set_sequence(sequence);
  own.mutable_stats()->set_skipped(skipped);
  const std::string fields = own.SerializeAsString();
  std::string head;
  constexpr std::uint64_t kLengthDelimited = 2;
  append_varint(std::uint64_t{v1::WatchResponse::kFrameFieldNumber} << 3 | kLengthDelimited, head);
  append_varint(fields.size() + rest_bytes, head);
  return head + fields;
}

std::string encode_ended(EndReason reason, std::string_view message) {
  v1::WatchResponse response;
  v1::Ended& ended = *response.mutable_ended();
  switch (reason) {
    case EndReason::kSheetDeleted:
      ended.set_reason(v1::Ended::SHEET_DELETED);
      break;
    case EndReason::kServerStopping:
      ended.set_reason(v1::Ended::SERVER_STOPPING);
      break;
    case EndReason::kTooSlow:
      ended.set_reason(v1::Ended::TOO_SLOW);
      break;
  }
  ended.set_message(std::string(message));
  return response.SerializeAsString();
}

std::string encode_rejection(std::string_view grab_id, const Error& error) {
  v1::WatchResponse response;
  v1::Rejection& rejection = *response.mutable_rejection();
  rejection.set_grab_id(std::string(grab_id));
  rejection.set_reason(error.reason);
  rejection.set_message(error.message);
  return response.SerializeAsString();
}

}  // namespace kerf::wire
