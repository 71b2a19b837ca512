#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/service/codec/vertex_predictors.h"

// Codes the arrays of a kerf.v1.TopologyPatch in few bytes, each as differences from earlier elements. Unpacking
// returns exactly what was packed, or nothing if the bytes are malformed. Ids are not checked against any limit.
namespace kerf::codec {

// Code strictly ascending ids as the gaps between them.
std::string pack_ascending(std::span<const std::uint32_t> ids);
std::optional<std::vector<std::uint32_t>> unpack_ascending(std::string_view bytes, std::size_t count);

// Code triangles, including empty slots (kNoVertex thrice), modulo 2^32. `whole`: all slots are packed. Each corner is
// then predicted as s[-2] + (s[-1] - s[-3]), with s[-n] the same corner of the n-th slot before: a grid's two triangles
// per cell repeat from cell to cell. If not all slots are packed, they are those that a cut rewrote, and the prediction
// is s[-1]. Slots before the first count as 0.
std::string pack_triangles(std::span<const std::array<std::int32_t, 3>> triangles, bool whole);
std::optional<std::vector<std::array<std::int32_t, 3>>> unpack_triangles(std::string_view bytes, std::size_t count,
                                                                         bool whole);

// Code labels that seldom change from one slot to the next.
std::string pack_labels(std::span<const std::int32_t> labels);
std::optional<std::vector<std::int32_t>> unpack_labels(std::string_view bytes, std::size_t count);

// Packs material positions of some vertices without loss. `material`: 2 per vertex, of all vertices, m. `listed`:
// ascending ids of those to be packed. Each is predicted from earlier vertices as in a keyframe, in 64-bit arithmetic
// rounded to 32 bits. The code holds the distance from the prediction, counted in representable 32-bit floats.
std::string pack_material_positions(std::span<const float> material, std::span<const std::uint32_t> listed,
                                    std::span<const VertexPredictor> predictors);
// Writes the listed vertices into `material`, which has room for all vertices and already holds the unlisted ones.
// Returns false if the bytes are malformed; `material` may then be partly overwritten.
[[nodiscard]] bool unpack_material_positions(std::string_view bytes, std::span<const std::uint32_t> listed,
                                             std::span<const VertexPredictor> predictors, std::span<float> material);

}  // namespace kerf::codec
