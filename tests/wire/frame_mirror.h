#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "kerf/v1/stream.pb.h"

namespace kerf::testing {

// Reads frames as kerf/v1/stream.proto describes them, sharing no code with the encoder.
class FrameMirror {
 public:
  // Nothing, or what is wrong with the frame; then the mirror is as it was only in parts.
  std::optional<std::string> apply(const v1::Frame& frame) {
    if (frame.sequence() != sequence + 1) return "sequence " + std::to_string(frame.sequence());
    sequence = frame.sequence();
    if (frame.has_topology()) {
      if (const auto fault = apply_topology(frame.topology(), frame.num_vertices())) return fault;
      topology_version = frame.topology_version();
    }
    if (frame.topology_version() != topology_version) return "positions of an unknown topology";
    if (const auto fault = apply_positions(frame)) return fault;
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
  std::int32_t num_pieces = 0;

 private:
  template <typename T>
  static T packed(const std::string& bytes, std::size_t index) {
    T value{};
    std::memcpy(&value, bytes.data() + index * sizeof(T), sizeof(T));
    return value;
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

  std::optional<std::string> apply_positions(const v1::Frame& frame) {
    const auto count = static_cast<std::size_t>(3 * frame.num_vertices());
    const std::array<double, 3> min{frame.box().min().x(), frame.box().min().y(), frame.box().min().z()};
    const std::array<double, 3> max{frame.box().max().x(), frame.box().max().y(), frame.box().max().z()};
    const std::string& bytes = frame.positions();
    if (frame.base_tick() == -1) {
      if (bytes.size() != 2 * count) return "keyframe of the wrong length";
      quantised.assign(count, 0);
      for (std::size_t i = 0; i < count; ++i) quantised[i] = packed<std::uint16_t>(bytes, i);
    } else {
      if (frame.base_tick() != tick) return "a delta against tick " + std::to_string(frame.base_tick());
      if (min != box_min || max != box_max) return "a delta in another box";
      quantised.resize(count, 0);
      std::size_t at = 0;
      for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t zigzag = 0;
        for (int shift = 0;; shift += 7) {
          if (at == bytes.size()) return "a delta that is too short";
          const auto byte = static_cast<unsigned char>(bytes[at++]);
          zigzag |= (byte & 0x7fU) << shift;
          if (byte < 0x80) break;
        }
        quantised[i] += static_cast<std::int32_t>(zigzag >> 1) ^ -static_cast<std::int32_t>(zigzag & 1);
        if (quantised[i] < 0 || quantised[i] > 65535) return "a delta that leaves the range";
      }
      if (at != bytes.size()) return "a delta that is too long";
    }
    box_min = min;
    box_max = max;
    return std::nullopt;
  }
};

}  // namespace kerf::testing
