#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/service/codec/vertex_predictors.h"

// Quantised positions in few bytes: each vertex as the difference to what earlier vertices foretell. All arithmetic is
// modulo 2^16, so that nothing can leave the range, whatever the bytes. See kerf.v1.Frame.positions.
//
// Keyframe: near_a + near_b - across, the fourth corner of the parallelogram (C. Touma, C. Gotsman, "Triangle mesh
// compression", Graphics Interface 1998); without `across` near_a, without that 0.
// Delta: how far a vertex has come since the base frame is foretold as the mean of near_a's and near_b's ways, rounded
// down, without near_b near_a's. (Motion is rougher than shape: a mean of two passes less of it on than three terms
// do.) A vertex that the base frame does not have is coded as in a keyframe.
namespace kerf::codec {

// `positions`: 3 a vertex, x, y, z interleaved; `predictors`: one a vertex.
std::string pack_positions(std::span<const std::uint16_t> positions, std::span<const VertexPredictor> predictors);
// `base`: of the first vertices, or of as many as there are.
std::string pack_position_delta(std::span<const std::uint16_t> positions, std::span<const std::uint16_t> base,
                                std::span<const VertexPredictor> predictors);

// Three a predictor, or nothing where the bytes are malformed.
std::optional<std::vector<std::uint16_t>> unpack_positions(std::string_view bytes,
                                                           std::span<const VertexPredictor> predictors);
std::optional<std::vector<std::uint16_t>> unpack_position_delta(std::string_view bytes,
                                                                std::span<const std::uint16_t> base,
                                                                std::span<const VertexPredictor> predictors);

// One signed byte a vertex (kerf.v1.Frame.strain), foretold as in a delta, modulo 2^8.
std::string pack_bytes(std::span<const std::int8_t> values, std::span<const VertexPredictor> predictors);
std::optional<std::vector<std::int8_t>> unpack_bytes(std::string_view bytes,
                                                     std::span<const VertexPredictor> predictors);

}  // namespace kerf::codec
