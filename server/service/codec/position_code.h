#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/service/codec/vertex_predictors.h"

// Codes quantised positions in few bytes: each vertex as the difference from a prediction by earlier vertices. All
// arithmetic is modulo 2^16, so no input can leave the range. See kerf.v1.Frame.positions.
//
// A keyframe predicts near_a + near_b - across, with the positions of the vertices that VertexPredictor names. This is
// the fourth corner of a parallelogram. (C. Touma, C. Gotsman, "Triangle mesh compression", Graphics Interface 1998.)
// Without `across` it predicts near_a, and without near_a 0.
//
// A delta predicts the displacement of a vertex since the base frame. The prediction is the mean of the displacements
// of near_a and near_b, rounded down, or that of near_a without near_b. (Motion is rougher than shape, and a mean of
// two displacements passes on less roughness than a sum of three.) A vertex that the base frame lacks is coded as in a
// keyframe.
namespace kerf::codec {

// `positions`: 3 per vertex, x, y, z interleaved. `predictors`: one per vertex.
std::string pack_positions(std::span<const std::uint16_t> positions, std::span<const VertexPredictor> predictors);
// `base`: positions of the base frame, which may have fewer vertices or more; the surplus is ignored.
std::string pack_position_delta(std::span<const std::uint16_t> positions, std::span<const std::uint16_t> base,
                                std::span<const VertexPredictor> predictors);

// Return three coordinates per predictor, or nothing if the bytes are malformed.
std::optional<std::vector<std::uint16_t>> unpack_positions(std::string_view bytes,
                                                           std::span<const VertexPredictor> predictors);
std::optional<std::vector<std::uint16_t>> unpack_position_delta(std::string_view bytes,
                                                                std::span<const std::uint16_t> base,
                                                                std::span<const VertexPredictor> predictors);

// Codes one signed byte per vertex (kerf.v1.Frame.strains), predicted as the displacements of a delta are, modulo 2^8.
std::string pack_bytes(std::span<const std::int8_t> values, std::span<const VertexPredictor> predictors);
std::optional<std::vector<std::int8_t>> unpack_bytes(std::string_view bytes,
                                                     std::span<const VertexPredictor> predictors);

}  // namespace kerf::codec
