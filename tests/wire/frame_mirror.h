#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "kerf/v1/stream.pb.h"
#include "server/service/codec/position_code.h"
#include "server/service/codec/topology_code.h"

namespace kerf::testing {

// Reads frames as kerf/v1/stream.proto describes them. It shares only the codec of compact frames with the encoder.
// web/test/golden_frames.test.ts reads those with code of its own.
class FrameMirror {
 public:
  // Nothing, or what is wrong with the frame; then the mirror is as it was only in parts.
  std::optional<std::string> apply(const v1::Frame& frame) {
    if (frame.sequence() != sequence + 1) return "sequence " + std::to_string(frame.sequence());
    sequence = frame.sequence();
    if (frame.has_topology()) {
      v1::TopologyPatch patch = frame.topology();
      if (frame.encoding() == v1::COMPACT && !make_raw(patch, frame.num_vertices())) return "a malformed topology";
      if (const auto fault = apply_topology(patch, frame.num_vertices())) return fault;
      topology_version = frame.topology_version();
    }
    if (frame.topology_version() != topology_version) return "positions of an unknown topology";
    if (const auto fault = apply_positions(frame)) return fault;
    if (const auto fault = apply_strains(frame)) return fault;
    tick = frame.tick();
    return std::nullopt;
  }

  [[nodiscard]] std::array<double, 3> position(std::size_t vertex) const {
    std::array<double, 3> p{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      p[axis] = box_min[axis] + quantised[3 * vertex + axis] * (box_max[axis] - box_min[axis]) / 65535.0;
    }
    return p;
  }

  std::int64_t sequence = 0;
  std::int64_t tick = -1;
  std::int32_t topology_version = -1;
  std::array<double, 3> box_min{};
  std::array<double, 3> box_max{};
  std::vector<std::int32_t> quantised;                 // 3 V
  std::vector<std::array<std::int32_t, 3>> triangles;  // a slot
  std::vector<std::int32_t> pieces;                    // a slot
  std::vector<std::array<float, 2>> material;          // a vertex
  std::vector<float> strains;                          // a vertex; empty where the last frame had none
  std::int32_t num_pieces = 0;

 private:
  template <typename T>
  static T packed(const std::string& bytes, std::size_t index) {
    T value{};
    std::memcpy(&value, bytes.data() + index * sizeof(T), sizeof(T));
    return value;
  }

  template <typename T>
  static std::string bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), sizeof(T) * values.size()};
  }

  // The patch with the arrays that a raw one has.
  bool make_raw(v1::TopologyPatch& patch, std::int32_t num_vertices) const {
    const bool full = patch.base_version() == -1;
    const auto n = static_cast<std::size_t>(patch.num_listed_slots());
    const auto m = static_cast<std::size_t>(patch.num_listed_vertices());
    const auto new_triangles = codec::unpack_triangles(patch.triangles(), n, full);
    const auto new_pieces = codec::unpack_labels(patch.pieces(), n);
    std::vector<std::uint32_t> slots(n);
    std::vector<std::uint32_t> vertices(m);
    std::iota(slots.begin(), slots.end(), 0U);
    std::iota(vertices.begin(), vertices.end(), 0U);
    if (!full) {
      const auto listed_slots = codec::unpack_ascending(patch.slots(), n);
      const auto listed_vertices = codec::unpack_ascending(patch.vertices(), m);
      if (!listed_slots || !listed_vertices) return false;
      patch.set_slots(bytes_of(slots = *listed_slots));
      patch.set_vertices(bytes_of(vertices = *listed_vertices));
    }
    if (!new_triangles || !new_pieces) return false;
    auto all = full ? decltype(triangles)() : triangles;
    all.resize(static_cast<std::size_t>(patch.num_slots()), {-1, -1, -1});
    for (std::size_t i = 0; i < n; ++i) all.at(slots[i]) = (*new_triangles)[i];
    std::vector<float> positions;
    for (const auto& position : material) positions.insert(positions.end(), position.begin(), position.end());
    positions.resize(2 * static_cast<std::size_t>(num_vertices));
    if (!codec::unpack_material_positions(patch.material_positions(), vertices,
                                          codec::vertex_predictors(all, static_cast<std::size_t>(num_vertices)),
                                          positions)) {
      return false;
    }
    std::vector<float> listed;
    for (const std::uint32_t vertex : vertices) {
      listed.insert(listed.end(), {positions[2 * vertex], positions[2 * vertex + 1]});
    }
    patch.set_triangles(bytes_of(*new_triangles));
    patch.set_pieces(bytes_of(*new_pieces));
    patch.set_material_positions(bytes_of(listed));
    return true;
  }

  std::optional<std::string> apply_topology(const v1::TopologyPatch& patch, std::int32_t num_vertices) {
    const bool full = patch.base_version() == -1;
    if (!full && patch.base_version() != topology_version) return "a patch for another version";
    if (full) {
      triangles.clear();
      pieces.clear();
      material.clear();
      if (!patch.slots().empty() || !patch.vertices().empty()) return "a full patch with lists";
    }
    triangles.resize(static_cast<std::size_t>(patch.num_slots()), {-2, -2, -2});
    pieces.resize(triangles.size(), -2);
    material.resize(static_cast<std::size_t>(num_vertices), {-1e9F, -1e9F});
    const std::size_t num_slots = full ? triangles.size() : patch.slots().size() / 4;
    if (patch.triangles().size() != 12 * num_slots || patch.pieces().size() != 4 * num_slots) return "slot arrays";
    for (std::size_t i = 0; i < num_slots; ++i) {
      const std::size_t slot = full ? i : packed<std::uint32_t>(patch.slots(), i);
      if (slot >= triangles.size()) return "a slot beyond the end";
      for (std::size_t k = 0; k < 3; ++k) triangles[slot][k] = packed<std::int32_t>(patch.triangles(), 3 * i + k);
      pieces[slot] = packed<std::int32_t>(patch.pieces(), i);
    }
    const std::size_t count = full ? material.size() : patch.vertices().size() / 4;
    if (patch.material_positions().size() != 8 * count) return "vertex arrays";
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t vertex = full ? i : packed<std::uint32_t>(patch.vertices(), i);
      if (vertex >= material.size()) return "a vertex beyond the end";
      material[vertex] = {packed<float>(patch.material_positions(), 2 * i),
                          packed<float>(patch.material_positions(), 2 * i + 1)};
    }
    num_pieces = patch.num_pieces();
    return std::nullopt;
  }

  std::optional<std::string> apply_strains(const v1::Frame& frame) {
    strains.clear();
    if (frame.strain_scale() == 0.0) return std::nullopt;
    const auto count = static_cast<std::size_t>(frame.num_vertices());
    std::optional<std::vector<std::int8_t>> values;
    if (frame.encoding() == v1::RAW) {
      values.emplace(frame.strains().begin(), frame.strains().end());
    } else {
      values = codec::unpack_bytes(frame.strains(), codec::vertex_predictors(triangles, count));
    }
    if (!values || values->size() != count) return "malformed strains";
    for (const std::int8_t q : *values) {
      strains.push_back(static_cast<float>((q / 127.0) * std::abs(q / 127.0) * frame.strain_scale()));
    }
    return std::nullopt;
  }

  std::optional<std::string> apply_positions(const v1::Frame& frame) {
    const auto count = static_cast<std::size_t>(3 * frame.num_vertices());
    const std::string& bytes = frame.positions();
    const bool is_keyframe = frame.base_tick() == -1;
    if (!is_keyframe && frame.base_tick() != tick) return "a delta against tick " + std::to_string(frame.base_tick());
    if (frame.has_box() != is_keyframe) return "a keyframe without a box, or a delta with one";
    if (frame.encoding() == v1::RAW) {
      if (!is_keyframe) return "a raw delta";
      if (bytes.size() != 2 * count) return "keyframe of the wrong length";
      quantised.assign(count, 0);
      for (std::size_t i = 0; i < count; ++i) quantised[i] = packed<std::uint16_t>(bytes, i);
    } else {
      const auto predictors = codec::vertex_predictors(triangles, count / 3);
      const std::vector<std::uint16_t> base(quantised.begin(), quantised.end());
      const auto positions = is_keyframe ? codec::unpack_positions(bytes, predictors)
                                         : codec::unpack_position_delta(bytes, base, predictors);
      if (!positions) return "malformed positions";
      quantised.assign(positions->begin(), positions->end());
    }
    if (!is_keyframe) return std::nullopt;
    box_min = {frame.box().min().x(), frame.box().min().y(), frame.box().min().z()};
    box_max = {frame.box().max().x(), frame.box().max().y(), frame.box().max().z()};
    return std::nullopt;
  }
};

}  // namespace kerf::testing
