#include "client/cpp/mirror.h"

#include <bit>
#include <cstddef>
#include <numeric>
#include <string_view>
#include <utility>

#include "server/service/codec/position_code.h"
#include "server/service/codec/topology_code.h"

namespace kerf::client {
namespace {

// Reads little-endian words of a packed array, regardless of the byte order of this machine.
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

std::string wrong_size(const char* what, std::size_t got, std::size_t expected) {
  return std::string(what) + " has " + std::to_string(got) + " bytes instead of " + std::to_string(expected);
}

// Returns the ids listed by a patch, or all of them in a full one.
std::optional<std::vector<std::uint32_t>> read_ids(const std::string& bytes, std::int32_t count, bool full,
                                                   bool compact) {
  if (count < 0) return std::nullopt;
  const auto size = static_cast<std::size_t>(count);
  if (full) {
    if (!bytes.empty()) return std::nullopt;
    std::vector<std::uint32_t> all(size);
    std::iota(all.begin(), all.end(), 0U);
    return all;
  }
  if (compact) return codec::unpack_ascending(bytes, size);
  if (bytes.size() != 4 * size) return std::nullopt;
  std::vector<std::uint32_t> ids(size);
  for (std::size_t i = 0; i < size; ++i) ids[i] = word_at(bytes, i);
  return ids;
}

std::optional<std::vector<std::array<std::int32_t, 3>>> read_triangles(const std::string& bytes, std::size_t count,
                                                                       bool full, bool compact) {
  if (compact) return codec::unpack_triangles(bytes, count, full);
  if (bytes.size() != 12 * count) return std::nullopt;
  std::vector<std::array<std::int32_t, 3>> triangles(count);
  for (std::size_t i = 0; i < 3 * count; ++i) triangles[i / 3][i % 3] = int_at(bytes, i);
  return triangles;
}

std::optional<std::vector<std::int32_t>> read_labels(const std::string& bytes, std::size_t count, bool compact) {
  if (compact) return codec::unpack_labels(bytes, count);
  if (bytes.size() != 4 * count) return std::nullopt;
  std::vector<std::int32_t> labels(count);
  for (std::size_t i = 0; i < count; ++i) labels[i] = int_at(bytes, i);
  return labels;
}

}  // namespace

std::optional<std::string> Mirror::apply(const v1::Frame& frame) {
  if (frame.num_vertices() < 0) return "negative vertex count";
  if (frame.sequence() != sequence_ + 1) {
    return "frame " + std::to_string(frame.sequence()) + " follows frame " + std::to_string(sequence_);
  }
  const bool begins = !frame.epoch().empty() && frame.base_tick() < 0;
  if (frame.tick() < tick_ && !begins)
    return "tick " + std::to_string(frame.tick()) + " after tick " + std::to_string(tick_);
  if (frame.encoding() != v1::COMPACT && frame.encoding() != v1::RAW) return "an unknown encoding";
  if (frame.has_topology()) {
    if (auto wrong = apply_topology(frame)) return wrong;
  } else if (frame.topology_version() != topology_version_) {
    return "topology version " + std::to_string(frame.topology_version()) + " without its patch";
  }
  if (material_positions_.size() != 2 * static_cast<std::size_t>(frame.num_vertices())) {
    return "vertices without material coordinates";
  }
  if (auto wrong = apply_positions(frame)) return wrong;
  if (auto wrong = apply_strains(frame)) return wrong;
  if (auto wrong = apply_probes(frame)) return wrong;
  topology_version_ = frame.topology_version();
  tick_ = frame.tick();
  if (!frame.epoch().empty()) epoch_ = frame.epoch();
  sequence_ = frame.sequence();
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_probes(const v1::Frame& frame) {
  if (frame.probe_columns_size() > 0) probe_columns_.assign(frame.probe_columns().begin(), frame.probe_columns().end());
  probe_values_.assign(frame.probe_values().begin(), frame.probe_values().end());
  if (probe_values_.size() == probe_columns_.size()) return std::nullopt;
  return std::to_string(probe_values_.size()) + " values of probes for " + std::to_string(probe_columns_.size()) +
         " columns";
}

const std::vector<codec::VertexPredictor>& Mirror::predictors(std::int32_t num_vertices) {
  if (!predictors_) predictors_ = codec::vertex_predictors(triangles_, static_cast<std::size_t>(num_vertices));
  return *predictors_;
}

std::optional<std::string> Mirror::apply_positions(const v1::Frame& frame) {
  const bool is_keyframe = frame.base_tick() < 0;
  if (!is_keyframe && frame.base_tick() != tick_) {
    return "delta against tick " + std::to_string(frame.base_tick()) + " at tick " + std::to_string(tick_);
  }
  const std::string& bytes = frame.positions();
  std::optional<std::vector<std::uint16_t>> positions;
  if (frame.encoding() == v1::COMPACT) {
    const auto& foretold = predictors(frame.num_vertices());
    positions = is_keyframe ? codec::unpack_positions(bytes, foretold)
                            : codec::unpack_position_delta(bytes, quantised_, foretold);
    if (!positions) return "positions are malformed";
  } else {
    const std::size_t count = 3 * static_cast<std::size_t>(frame.num_vertices());
    if (!is_keyframe) return "a delta that is not compact";
    if (bytes.size() != 2 * count) return wrong_size("positions", bytes.size(), 2 * count);
    positions.emplace(count);
    for (std::size_t i = 0; i < count; ++i) (*positions)[i] = short_at(bytes, i);
  }
  quantised_ = std::move(*positions);
  if (is_keyframe) box_ = frame.box();
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_strains(const v1::Frame& frame) {
  const std::string& bytes = frame.strains();
  strains_.clear();
  strain_scale_ = frame.strain_scale();
  if (strain_scale_ == 0.0) return bytes.empty() ? std::nullopt : std::optional<std::string>("strains without a scale");
  if (frame.encoding() == v1::COMPACT) {
    auto strains = codec::unpack_bytes(bytes, predictors(frame.num_vertices()));
    if (!strains) return "strains are malformed";
    strains_ = std::move(*strains);
    return std::nullopt;
  }
  const auto count = static_cast<std::size_t>(frame.num_vertices());
  if (bytes.size() != count) return wrong_size("strains", bytes.size(), count);
  strains_.assign(bytes.begin(), bytes.end());
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_topology(const v1::Frame& frame) {
  const v1::TopologyPatch& message = frame.topology();
  const bool full = message.base_version() < 0;
  if (!full && message.base_version() != topology_version_) {
    return "topology patch from version " + std::to_string(message.base_version()) + " at version " +
           std::to_string(topology_version_);
  }
  if (message.num_slots() < 0) return "negative slot count";
  if (full) {
    if (message.num_listed_slots() != message.num_slots()) return "a full patch lists some of its slots";
    if (message.num_listed_vertices() != frame.num_vertices()) return "a full patch lists some of its vertices";
    triangles_.clear();
    pieces_.clear();
    material_positions_.clear();
  } else if (static_cast<std::size_t>(message.num_slots()) < triangles_.size()) {
    return "a patch must not remove slots";
  }
  const bool compact = frame.encoding() == v1::COMPACT;
  auto slots = read_ids(message.slots(), message.num_listed_slots(), full, compact);
  if (!slots) return "slots is malformed";
  auto triangles = read_triangles(message.triangles(), slots->size(), full, compact);
  if (!triangles) return "triangles is malformed";
  auto pieces = read_labels(message.pieces(), slots->size(), compact);
  if (!pieces) return "pieces is malformed";
  auto vertices = read_ids(message.vertices(), message.num_listed_vertices(), full, compact);
  if (!vertices) return "vertices is malformed";
  const Patch patch{std::move(*slots), std::move(*triangles), std::move(*pieces), std::move(*vertices)};
  if (auto wrong = apply_triangles(message, patch, frame.num_vertices())) return wrong;
  if (auto wrong = apply_materials(frame, patch.vertices)) return wrong;
  num_pieces_ = message.num_pieces();
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_triangles(const v1::TopologyPatch& message, const Patch& patch,
                                                   std::int32_t num_vertices) {
  const std::size_t num_slots = static_cast<std::size_t>(message.num_slots());
  predictors_.reset();
  triangles_.resize(num_slots, {-1, -1, -1});
  pieces_.resize(num_slots, -1);
  for (std::size_t i = 0; i < patch.slots.size(); ++i) {
    const std::size_t slot = patch.slots[i];
    if (slot >= num_slots) return "slot " + std::to_string(slot) + " is out of range";
    const std::array<std::int32_t, 3>& triangle = patch.triangles[i];
    const bool is_void = triangle == std::array<std::int32_t, 3>{-1, -1, -1};
    for (const std::int32_t vertex : triangle) {
      if (!is_void && (vertex < 0 || vertex >= num_vertices)) {
        return "vertex " + std::to_string(vertex) + " is out of range";
      }
    }
    triangles_[slot] = triangle;
    pieces_[slot] = patch.pieces[i];
  }
  return std::nullopt;
}

std::optional<std::string> Mirror::apply_materials(const v1::Frame& frame, const std::vector<std::uint32_t>& vertices) {
  const std::string& bytes = frame.topology().material_positions();
  const std::size_t count = static_cast<std::size_t>(frame.num_vertices());
  if (2 * count < material_positions_.size()) return "a patch must not remove vertices";
  const std::size_t known = material_positions_.size() / 2;
  std::size_t added = 0;
  for (const std::uint32_t vertex : vertices) {
    if (vertex >= count) return "vertex " + std::to_string(vertex) + " is out of range";
    if (vertex >= known) ++added;
  }
  if (added != count - known) return "new vertices without material coordinates";
  material_positions_.resize(2 * count);
  if (frame.encoding() == v1::COMPACT) {
    if (codec::unpack_material_positions(bytes, vertices, predictors(frame.num_vertices()), material_positions_)) {
      return std::nullopt;
    }
    return "material_positions is malformed";
  }
  if (bytes.size() != 8 * vertices.size()) return wrong_size("material_positions", bytes.size(), 8 * vertices.size());
  for (std::size_t i = 0; i < 2 * vertices.size(); ++i) {
    material_positions_[2 * vertices[i / 2] + i % 2] = std::bit_cast<float>(word_at(bytes, i));
  }
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
