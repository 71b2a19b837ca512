#include "server/service/wire/frame_encoder.h"

#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

#include "kerf/v1/stream.pb.h"
#include "server/base/check.h"
#include "server/service/codec/position_code.h"
#include "server/service/codec/topology_code.h"

namespace kerf::wire {
namespace {

static_assert(std::endian::native == std::endian::little, "packed arrays are copied as they lie in memory");

template <typename T>
void append_packed(T value, std::string& bytes) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

// Holds the slots and vertices listed by a patch, ascending.
struct Listed {
  std::vector<std::uint32_t> slots;
  std::vector<std::uint32_t> vertices;
};

// Returns the ascending indices of the entries changed by a version after `base_version`.
std::vector<std::uint32_t> changed_since(const std::vector<std::int32_t>& versions, std::int32_t base_version) {
  std::vector<std::uint32_t> changed;
  for (std::size_t i = 0; i < versions.size(); ++i) {
    if (versions[i] > base_version) changed.push_back(static_cast<std::uint32_t>(i));
  }
  return changed;
}

// Returns the changes, or nothing if a full patch serves the viewer better.
std::optional<Listed> list_changes(const sheet::Topology& topology, std::int32_t base_version) {
  if (!can_patch(topology, base_version)) return std::nullopt;
  Listed listed{changed_since(topology.slot_versions, base_version),
                changed_since(topology.vertex_versions, base_version)};
  // Compares bytes of the raw arrays. A patch that lists changes also has the ids of the listed slots and vertices.
  const std::size_t bytes = 20 * listed.slots.size() + 12 * listed.vertices.size();
  if (bytes >= 16 * topology.triangles.size() + 8 * topology.vertex_versions.size()) return std::nullopt;
  return listed;
}

Listed list_all(const sheet::Topology& topology) {
  Listed listed{std::vector<std::uint32_t>(topology.triangles.size()),
                std::vector<std::uint32_t>(topology.vertex_versions.size())};
  std::iota(listed.slots.begin(), listed.slots.end(), 0U);
  std::iota(listed.vertices.begin(), listed.vertices.end(), 0U);
  return listed;
}

void fill_raw(const sheet::Topology& topology, const Listed& listed, v1::TopologyPatch& patch) {
  const bool lists = patch.base_version() >= 0;
  for (const std::uint32_t slot : listed.slots) {
    if (lists) append_packed(slot, *patch.mutable_slots());
    for (const mesh::VertexId vertex : topology.triangles[slot]) append_packed(vertex, *patch.mutable_triangles());
    append_packed(topology.pieces[slot], *patch.mutable_pieces());
  }
  for (const std::uint32_t vertex : listed.vertices) {
    if (lists) append_packed(vertex, *patch.mutable_vertices());
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      append_packed(static_cast<float>(topology.material_positions(axis, static_cast<Eigen::Index>(vertex))),
                    *patch.mutable_material_positions());
    }
  }
}

void fill_compact(const sheet::Topology& topology, const Listed& listed, const Predictors& predictors,
                  v1::TopologyPatch& patch) {
  const bool lists = patch.base_version() >= 0;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::int32_t> pieces;
  triangles.reserve(listed.slots.size());
  pieces.reserve(listed.slots.size());
  for (const std::uint32_t slot : listed.slots) {
    triangles.push_back(topology.triangles[slot]);
    pieces.push_back(topology.pieces[slot]);
  }
  const Eigen::Matrix2Xf material = topology.material_positions.cast<float>();
  if (lists) patch.set_slots(codec::pack_ascending(listed.slots));
  if (lists) patch.set_vertices(codec::pack_ascending(listed.vertices));
  patch.set_triangles(codec::pack_triangles(triangles, !lists));
  patch.set_pieces(codec::pack_labels(pieces));
  patch.set_material_positions(codec::pack_material_positions(
      {material.data(), static_cast<std::size_t>(material.size())}, listed.vertices, predictors));
}

void encode_box(const FrameBox& box, v1::Box3& message) {
  v1::Vec3& min = *message.mutable_min();
  min.set_x(box.min[0]);
  min.set_y(box.min[1]);
  min.set_z(box.min[2]);
  v1::Vec3& max = *message.mutable_max();
  max.set_x(box.min[0] + box.size[0]);
  max.set_y(box.min[1] + box.size[1]);
  max.set_z(box.min[2] + box.size[2]);
}

// Begins a body: everything except base_tick, box and positions.
v1::Frame begin_body(const QuantisedFrame& frame, v1::Encoding encoding) {
  v1::Frame message;
  message.set_tick(frame.tick);
  message.set_topology_version(frame.topology->version);
  message.set_num_vertices(static_cast<std::int32_t>(frame.positions.size() / 3));
  message.set_encoding(encoding);
  encode_stats(frame.stats, *frame.topology, *message.mutable_stats());
  return message;
}

std::string keyframe_body(const QuantisedFrame& frame, v1::Encoding encoding, std::string positions) {
  v1::Frame message = begin_body(frame, encoding);
  message.set_base_tick(-1);
  encode_box(frame.box, *message.mutable_box());
  message.set_positions(std::move(positions));
  return message.SerializeAsString();
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
  if (!snapshot.strains.empty()) frame.strains = quantise_strains(snapshot.strains);
  return frame;
}

Predictors make_predictors(const sheet::Topology& topology) {
  return codec::vertex_predictors(topology.triangles, topology.vertex_versions.size());
}

std::string encode_raw_body(const QuantisedFrame& frame) {
  std::string positions(sizeof(frame.positions[0]) * frame.positions.size(), '\0');
  std::memcpy(positions.data(), frame.positions.data(), positions.size());
  return keyframe_body(frame, v1::RAW, std::move(positions));
}

std::string encode_keyframe_body(const QuantisedFrame& frame, const Predictors& predictors) {
  return keyframe_body(frame, v1::COMPACT, codec::pack_positions(frame.positions, predictors));
}

std::string encode_delta_body(const QuantisedFrame& frame, const QuantisedFrame& base, const Predictors& predictors) {
  KERF_CHECK(base.box == frame.box, "a delta needs the box of its base");
  v1::Frame message = begin_body(frame, v1::COMPACT);
  message.set_base_tick(base.tick);
  message.set_positions(codec::pack_position_delta(frame.positions, base.positions, predictors));
  return message.SerializeAsString();
}

std::string encode_strains(const QuantisedFrame& frame, const Predictors* predictors) {
  const std::vector<std::int8_t>& values = frame.strains->values;
  v1::Frame message;
  message.set_strain_scale(frame.strains->scale);
  message.set_strains(predictors != nullptr ? codec::pack_bytes(values, *predictors)
                                            : std::string(reinterpret_cast<const char*>(values.data()), values.size()));
  return message.SerializeAsString();
}

std::string encode_probe_values(const std::vector<double>& values, const std::vector<std::string>* columns) {
  v1::Frame message;
  message.mutable_probe_values()->Assign(values.begin(), values.end());
  if (columns != nullptr) message.mutable_probe_columns()->Assign(columns->begin(), columns->end());
  return message.SerializeAsString();
}

bool can_patch(const sheet::Topology& topology, std::int32_t base_version) {
  return base_version >= topology.patchable_since && base_version <= topology.version;
}

EncodedTopology encode_topology(const sheet::Topology& topology, std::int32_t base_version,
                                const Predictors* predictors) {
  v1::Frame message;
  v1::TopologyPatch& patch = *message.mutable_topology();
  const std::optional<Listed> changes = list_changes(topology, base_version);
  const Listed listed = changes ? *changes : list_all(topology);
  patch.set_base_version(changes ? base_version : -1);
  patch.set_num_slots(static_cast<std::int32_t>(topology.triangles.size()));
  patch.set_num_pieces(topology.num_pieces);
  patch.set_num_listed_slots(static_cast<std::int32_t>(listed.slots.size()));
  patch.set_num_listed_vertices(static_cast<std::int32_t>(listed.vertices.size()));
  if (predictors != nullptr) {
    fill_compact(topology, listed, *predictors, patch);
  } else {
    fill_raw(topology, listed, patch);
  }
  return {message.SerializeAsString(), !changes.has_value()};
}

std::string encode_frame_head(std::int64_t sequence, std::int64_t skipped, std::string_view epoch,
                              std::size_t rest_bytes) {
  v1::Frame own;
  own.set_sequence(sequence);
  own.set_epoch(std::string(epoch));
  own.mutable_stats()->set_skipped(skipped);
  const std::string fields = own.SerializeAsString();
  return begin_field(v1::WatchResponse::kFrameFieldNumber, fields.size() + rest_bytes) + fields;
}

std::string encode_ended(EndReason reason) {
  v1::WatchResponse response;
  encode_end(reason, *response.mutable_ended());
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
