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

// The arrays of a kerf.v1.TopologyPatch in few bytes, each as differences to what came before. Whoever unpacks gets
// exactly what was packed, or nothing where the bytes are malformed; ids are not checked against any limit.
namespace kerf::codec {

// Strictly ascending ids: the gaps between them.
std::string pack_ascending(std::span<const std::uint32_t> ids);
std::optional<std::vector<std::uint32_t>> unpack_ascending(std::string_view bytes, std::size_t count);

// Triangles, kNoVertex thrice included. `whole`: of all slots, where a grid's two triangles a cell go on from cell to
// cell, and so each corner is foretold as s[-2] + (s[-1] - s[-3]) of the slots before; else, of slots that a cut has
// rewritten, as s[-1]. (All modulo 2^32; what is before the first slot counts as 0.)
std::string pack_triangles(std::span<const std::array<std::int32_t, 3>> triangles, bool whole);
std::optional<std::vector<std::array<std::int32_t, 3>>> unpack_triangles(std::string_view bytes, std::size_t count,
                                                                         bool whole);

// Labels that seldom change from one slot to the next.
std::string pack_labels(std::span<const std::int32_t> labels);
std::optional<std::vector<std::int32_t>> unpack_labels(std::string_view bytes, std::size_t count);

// Material positions of some vertices, exactly. `material`: 2 a vertex, of all vertices, m; `listed`: ascending ids of
// those to be packed, which are foretold from vertices before them as positions in a keyframe, in 64-bit arithmetic
// rounded to 32 bits, and differ from that by so many representable numbers.
std::string pack_material_positions(std::span<const float> material, std::span<const std::uint32_t> listed,
                                    std::span<const VertexPredictor> predictors);
// Writes the listed vertices into `material`, which has room for all of them and holds the others. False where the
// bytes are malformed; `material` is then changed in parts.
[[nodiscard]] bool unpack_material_positions(std::string_view bytes, std::span<const std::uint32_t> listed,
                                             std::span<const VertexPredictor> predictors, std::span<float> material);

}  // namespace kerf::codec
