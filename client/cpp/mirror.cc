#include "client/cpp/mirror.h"

#include <bit>
#include <cstddef>
#include <cstring>
#include <string_view>

namespace kerf::client {
namespace {

// Little-endian words of a packed array, whatever the byte order here.
std::uint32_t word_at(std::string_view bytes, std::size_t index) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[4 * index + i])) << (8 * i);
  }
  return word;
}
std::int32_t int_at(std::string_view bytes, std::size_t index) {
  return static_cast<std::int32_t>(word_at(bytes, index));
}
std::uint16_t short_at(std::string_view bytes, std::size_t index) {
  return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[2 * index]) |
                                    (static_cast<unsigned char>(bytes[2 * index + 1]) << 8));
}

// Base-128 varints of at most three bytes: a zigzag difference of two 16-bit numbers has 17 bits.
class VarintReader {
 public:
  explicit VarintReader(std::string_view bytes) : bytes_(bytes) {}

  bool next(std::uint32_t& value) {
    value = 0;
    for (unsigned shift = 0; shift < 21; shift += 7) {
      if (at_ == bytes_.size()) return false;
      const auto byte = static_cast<unsigned char>(bytes_[at_++]);
      value |= static_cast<std::uint32_t>(byte & 0x7fU) << shift;
      if ((byte & 0x80U) == 0) return true;
    }
    return false;
  }
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

bool equal(const v1::Vec3& a, const v1::Vec3& b) {
  return a.x() == b.x() && a.y() == b.y() && a.z() == b.z();
}
bool equal(const v1::Box3& a, const v1::Box3& b) {
  return equal(a.min(), b.min()) && equal(a.max(), b.max());
}

std::string wrong_size(const char* what, std::size_t got, std::size_t expected) {
  return std::string(what) + " has " + std::to_string(got) + " bytes instead of " + std::to_string(expected);
}

}  // namespace

std::optional<std::string> Mirror::apply(const v1::Frame& frame) {
  if (frame.num_vertices() < 0) return "negative vertex count";
  if (frame.sequence() != sequence_ + 1) {
    return "frame " + std::to_string(frame.sequence()) + " follows frame " + std::to_string(sequence_);
  }
  if (frame.tick() < tick_) return "tick " + std::to_string(frame.tick()) + " after tick " + std::to_string(tick_);
  if (frame.has_topology()) {
    if (auto wrong = apply_topology(frame.topology(), frame.num_vertices())) return wrong;
  } else if (frame.topology_version() != topology_version_) {
    return "topology version " + std::to_string(frame.topology_version()) + " without its patch";
  }
  if (auto wrong = apply_positions(frame)) return wrong;
  if (material_positions_.size() != 2 * static_cast<std::size_t>(frame.num_vertices())) {
    return "vertices without material coordinates";
  }
  topology_version_ = frame.topology_version();
  tick_ = frame.tick();
  sequence_ = frame.sequence();
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_positions(const v1::Frame& frame) {
  const std::size_t count = 3 * static_cast<std::size_t>(frame.num_vertices());
  const std::string& bytes = frame.positions();
  if (frame.base_tick() < 0) {
    if (bytes.size() != 2 * count) return wrong_size("positions", bytes.size(), 2 * count);
    quantised_.resize(count);
    for (std::size_t i = 0; i < count; ++i) quantised_[i] = short_at(bytes, i);
    box_ = frame.box();
    return std::nullopt;
  }
  if (frame.base_tick() != tick_) {
    return "delta against tick " + std::to_string(frame.base_tick()) + " at tick " + std::to_string(tick_);
  }
  if (!equal(frame.box(), box_)) return "delta in another box";
  quantised_.resize(count, 0);
  VarintReader reader(bytes);
  for (std::uint16_t& q : quantised_) {
    std::uint32_t zigzag = 0;
    if (!reader.next(zigzag)) return "positions end early or hold a number that is too long";
    const std::int32_t difference = static_cast<std::int32_t>(zigzag >> 1) ^ -static_cast<std::int32_t>(zigzag & 1U);
    const std::int32_t sum = static_cast<std::int32_t>(q) + difference;
    if (sum < 0 || sum > 0xffff) return "a coordinate leaves 0..65535";
    q = static_cast<std::uint16_t>(sum);
  }
  if (!reader.at_end()) return "positions go on after the last vertex";
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_topology(const v1::TopologyPatch& patch, std::int32_t num_vertices) {
  const bool full = patch.base_version() < 0;
  if (!full && patch.base_version() != topology_version_) {
    return "topology patch from version " + std::to_string(patch.base_version()) + " at version " +
           std::to_string(topology_version_);
  }
  if (patch.num_slots() < 0) return "negative slot count";
  if (full) {
    triangles_.clear();
    pieces_.clear();
    material_positions_.clear();
  } else if (static_cast<std::size_t>(patch.num_slots()) < triangles_.size()) {
    return "a patch must not take slots away";
  }
  if (auto wrong = apply_triangles(patch, num_vertices)) return wrong;
  if (auto wrong = apply_materials(patch, num_vertices)) return wrong;
  num_pieces_ = patch.num_pieces();
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_triangles(const v1::TopologyPatch& patch, std::int32_t num_vertices) {
  const bool full = patch.base_version() < 0;
  const std::size_t num_slots = static_cast<std::size_t>(patch.num_slots());
  const std::size_t changed = full ? num_slots : patch.slots().size() / 4;
  if (full ? !patch.slots().empty() : patch.slots().size() % 4 != 0) return "slots is malformed";
  if (patch.triangles().size() != 12 * changed) return wrong_size("triangles", patch.triangles().size(), 12 * changed);
  if (patch.pieces().size() != 4 * changed) return wrong_size("pieces", patch.pieces().size(), 4 * changed);
  triangles_.resize(num_slots, {-1, -1, -1});
  pieces_.resize(num_slots, -1);
  for (std::size_t i = 0; i < changed; ++i) {
    const std::size_t slot = full ? i : word_at(patch.slots(), i);
    if (slot >= num_slots) return "slot " + std::to_string(slot) + " is out of range";
    std::array<std::int32_t, 3> vertices{};
    for (std::size_t k = 0; k < 3; ++k) {
      vertices[k] = int_at(patch.triangles(), 3 * i + k);
      if (vertices[k] < -1 || vertices[k] >= num_vertices) {
        return "vertex " + std::to_string(vertices[k]) + " is out of range";
      }
    }
    triangles_[slot] = vertices;
    pieces_[slot] = int_at(patch.pieces(), i);
  }
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_materials(const v1::TopologyPatch& patch, std::int32_t num_vertices) {
  const bool full = patch.base_version() < 0;
  const std::size_t count = static_cast<std::size_t>(num_vertices);
  const std::size_t changed = full ? count : patch.vertices().size() / 4;
  if (full ? !patch.vertices().empty() : patch.vertices().size() % 4 != 0) return "vertices is malformed";
  if (patch.material_positions().size() != 8 * changed) {
    return wrong_size("material_positions", patch.material_positions().size(), 8 * changed);
  }
  if (2 * count < material_positions_.size()) return "a patch must not take vertices away";
  const std::size_t known = material_positions_.size() / 2;
  std::size_t added = 0;
  material_positions_.resize(2 * count);
  for (std::size_t i = 0; i < changed; ++i) {
    const std::size_t vertex = full ? i : word_at(patch.vertices(), i);
    if (vertex >= count) return "vertex " + std::to_string(vertex) + " is out of range";
    if (vertex >= known) ++added;
    for (std::size_t k = 0; k < 2; ++k) {
      material_positions_[2 * vertex + k] = std::bit_cast<float>(word_at(patch.material_positions(), 2 * i + k));
    }
  }
  if (added != count - known) return "new vertices without material coordinates";
  return std::nullopt;
}

std::array<double, 3> Mirror::position(std::int32_t vertex) const {
  const std::size_t at = 3 * static_cast<std::size_t>(vertex);
  const auto coordinate = [](double low, double high, std::uint16_t q) {
    return low + static_cast<double>(q) * (high - low) / 65535.0;
  };
  return {coordinate(box_.min().x(), box_.max().x(), quantised_[at]),
          coordinate(box_.min().y(), box_.max().y(), quantised_[at + 1]),
          coordinate(box_.min().z(), box_.max().z(), quantised_[at + 2])};
}

}  // namespace kerf::client
