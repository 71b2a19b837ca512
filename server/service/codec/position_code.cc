#include "server/service/codec/position_code.h"

#include <algorithm>

#include "server/base/check.h"
#include "server/service/codec/packed_integers.h"

namespace kerf::codec {
namespace {

// Predicts coordinates from those of earlier vertices. `positions` need only be filled up to the vertex.
class Foretold {
 public:
  Foretold(std::span<const std::uint16_t> positions, std::span<const std::uint16_t> base)
      : positions_(positions), base_(base) {}

  [[nodiscard]] std::uint16_t at(std::size_t vertex, std::size_t axis, const VertexPredictor& predictor) const {
    if (3 * vertex >= base_.size()) return from_shape(predictor, axis);
    const std::uint16_t from = base_[3 * vertex + axis];
    return static_cast<std::uint16_t>(from + from_motion(predictor, axis));
  }

 private:
  [[nodiscard]] static std::size_t index(std::int32_t vertex, std::size_t axis) {
    return 3 * static_cast<std::size_t>(vertex) + axis;
  }
  [[nodiscard]] std::uint16_t from_shape(const VertexPredictor& predictor, std::size_t axis) const {
    if (predictor.near_a == kNoVertex) return 0;
    const std::uint16_t near_a = positions_[index(predictor.near_a, axis)];
    if (predictor.across == kNoVertex) return near_a;
    return static_cast<std::uint16_t>(near_a + positions_[index(predictor.near_b, axis)] -
                                      positions_[index(predictor.across, axis)]);
  }
  // Returns the displacement of `vertex` since the base frame, modulo 2^16. A base frame that has a vertex has all
  // vertices of lower ids, too.
  [[nodiscard]] std::int32_t way(std::int32_t vertex, std::size_t axis) const {
    const std::size_t at = index(vertex, axis);
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(positions_[at] - base_[at]));
  }
  [[nodiscard]] std::int32_t from_motion(const VertexPredictor& predictor, std::size_t axis) const {
    if (predictor.near_a == kNoVertex) return 0;
    if (predictor.near_b == kNoVertex) return way(predictor.near_a, axis);
    return (way(predictor.near_a, axis) + way(predictor.near_b, axis)) >> 1;
  }

  std::span<const std::uint16_t> positions_;
  std::span<const std::uint16_t> base_;
};

std::int32_t foretold_byte(std::span<const std::int8_t> values, const VertexPredictor& predictor) {
  if (predictor.near_a == kNoVertex) return 0;
  const std::int32_t near_a = values[static_cast<std::size_t>(predictor.near_a)];
  if (predictor.near_b == kNoVertex) return near_a;
  return (near_a + values[static_cast<std::size_t>(predictor.near_b)]) >> 1;
}

}  // namespace

std::string pack_positions(std::span<const std::uint16_t> positions, std::span<const VertexPredictor> predictors) {
  return pack_position_delta(positions, {}, predictors);
}

std::string pack_position_delta(std::span<const std::uint16_t> positions, std::span<const std::uint16_t> base,
                                std::span<const VertexPredictor> predictors) {
  KERF_CHECK(positions.size() == 3 * predictors.size(), "positions and predictors of different vertices");
  const Foretold foretold(positions, base.first(std::min(base.size(), positions.size())));
  std::vector<std::uint32_t> differences(positions.size());
  for (std::size_t vertex = 0; vertex < predictors.size(); ++vertex) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t at = 3 * vertex + axis;
      const auto difference = static_cast<std::uint16_t>(positions[at] - foretold.at(vertex, axis, predictors[vertex]));
      differences[at] = zigzag(static_cast<std::int16_t>(difference));
    }
  }
  return pack_integers(differences, 3);
}

std::optional<std::vector<std::uint16_t>> unpack_positions(std::string_view bytes,
                                                           std::span<const VertexPredictor> predictors) {
  return unpack_position_delta(bytes, {}, predictors);
}

std::optional<std::vector<std::uint16_t>> unpack_position_delta(std::string_view bytes,
                                                                std::span<const std::uint16_t> base,
                                                                std::span<const VertexPredictor> predictors) {
  const auto differences = unpack_integers(bytes, 3 * predictors.size(), 3);
  if (!differences) return std::nullopt;
  std::vector<std::uint16_t> positions(differences->size());
  const Foretold foretold(positions, base.first(std::min(base.size(), positions.size())));
  for (std::size_t vertex = 0; vertex < predictors.size(); ++vertex) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t at = 3 * vertex + axis;
      positions[at] =
          static_cast<std::uint16_t>(foretold.at(vertex, axis, predictors[vertex]) + unzigzag((*differences)[at]));
    }
  }
  return positions;
}

std::string pack_bytes(std::span<const std::int8_t> values, std::span<const VertexPredictor> predictors) {
  KERF_CHECK(values.size() == predictors.size(), "values and predictors of different vertices");
  std::vector<std::uint32_t> differences(values.size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    differences[v] = zigzag(static_cast<std::int8_t>(values[v] - foretold_byte(values, predictors[v])));
  }
  return pack_integers(differences, 1);
}

std::optional<std::vector<std::int8_t>> unpack_bytes(std::string_view bytes,
                                                     std::span<const VertexPredictor> predictors) {
  const auto differences = unpack_integers(bytes, predictors.size(), 1);
  if (!differences) return std::nullopt;
  std::vector<std::int8_t> values(differences->size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    values[v] = static_cast<std::int8_t>(foretold_byte(values, predictors[v]) + unzigzag((*differences)[v]));
  }
  return values;
}

}  // namespace kerf::codec
