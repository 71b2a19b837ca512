#include "server/service/codec/topology_code.h"

#include <bit>

#include "server/base/check.h"
#include "server/service/codec/packed_integers.h"

namespace kerf::codec {
namespace {

using Triangle = std::array<std::int32_t, 3>;

std::uint32_t foretold_corner(std::span<const Triangle> triangles, std::size_t slot, std::size_t k, bool whole) {
  const auto back = [&](std::size_t distance) {
    return slot < distance ? 0U : static_cast<std::uint32_t>(triangles[slot - distance][k]);
  };
  return whole ? back(1) + back(2) - back(3) : back(1);
}

// Maps 32-bit floats to integers in the same order, so that neighbouring floats differ by one.
std::uint32_t order_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}
float float_of(std::uint32_t order) {
  return std::bit_cast<float>((order & 0x80000000U) != 0 ? order & 0x7fffffffU : ~order);
}

float foretold_material(std::span<const float> material, const VertexPredictor& predictor, std::size_t axis) {
  const auto at = [&](std::int32_t vertex) {
    return static_cast<double>(material[2 * static_cast<std::size_t>(vertex) + axis]);
  };
  if (predictor.near_a == kNoVertex) return 0.0F;
  if (predictor.across == kNoVertex) return material[2 * static_cast<std::size_t>(predictor.near_a) + axis];
  return static_cast<float>(at(predictor.near_a) + at(predictor.near_b) - at(predictor.across));
}

}  // namespace

std::string pack_ascending(std::span<const std::uint32_t> ids) {
  std::vector<std::uint32_t> gaps(ids.size());
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    KERF_CHECK(ids[i] >= next, "ids that do not ascend");
    gaps[i] = ids[i] - next;
    next = ids[i] + 1;
  }
  return pack_integers(gaps, 1);
}

std::optional<std::vector<std::uint32_t>> unpack_ascending(std::string_view bytes, std::size_t count) {
  auto ids = unpack_integers(bytes, count, 1);
  if (!ids) return std::nullopt;
  std::uint64_t next = 0;
  for (std::uint32_t& id : *ids) {
    next += id;
    if (next > 0xffffffffU) return std::nullopt;
    id = static_cast<std::uint32_t>(next++);
  }
  return ids;
}

std::string pack_triangles(std::span<const Triangle> triangles, bool whole) {
  std::vector<std::uint32_t> differences(3 * triangles.size());
  for (std::size_t slot = 0; slot < triangles.size(); ++slot) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t difference =
          static_cast<std::uint32_t>(triangles[slot][k]) - foretold_corner(triangles, slot, k, whole);
      differences[3 * slot + k] = zigzag(static_cast<std::int32_t>(difference));
    }
  }
  return pack_integers(differences, 3);
}

std::optional<std::vector<Triangle>> unpack_triangles(std::string_view bytes, std::size_t count, bool whole) {
  const auto differences = unpack_integers(bytes, 3 * count, 3);
  if (!differences) return std::nullopt;
  std::vector<Triangle> triangles(count);
  for (std::size_t slot = 0; slot < count; ++slot) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto difference = static_cast<std::uint32_t>(unzigzag((*differences)[3 * slot + k]));
      triangles[slot][k] = static_cast<std::int32_t>(foretold_corner(triangles, slot, k, whole) + difference);
    }
  }
  return triangles;
}

std::string pack_labels(std::span<const std::int32_t> labels) {
  std::vector<std::uint32_t> differences(labels.size());
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto label = static_cast<std::uint32_t>(labels[i]);
    differences[i] = zigzag(static_cast<std::int32_t>(label - last));
    last = label;
  }
  return pack_integers(differences, 1);
}

std::optional<std::vector<std::int32_t>> unpack_labels(std::string_view bytes, std::size_t count) {
  const auto differences = unpack_integers(bytes, count, 1);
  if (!differences) return std::nullopt;
  std::vector<std::int32_t> labels(count);
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < count; ++i) {
    last += static_cast<std::uint32_t>(unzigzag((*differences)[i]));
    labels[i] = static_cast<std::int32_t>(last);
  }
  return labels;
}

std::string pack_material_positions(std::span<const float> material, std::span<const std::uint32_t> listed,
                                    std::span<const VertexPredictor> predictors) {
  std::vector<std::uint32_t> differences(2 * listed.size());
  for (std::size_t i = 0; i < listed.size(); ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const float foretold = foretold_material(material, predictors[listed[i]], axis);
      const std::uint32_t difference = order_of(material[2 * listed[i] + axis]) - order_of(foretold);
      differences[2 * i + axis] = zigzag(static_cast<std::int32_t>(difference));
    }
  }
  return pack_integers(differences, 2);
}

bool unpack_material_positions(std::string_view bytes, std::span<const std::uint32_t> listed,
                               std::span<const VertexPredictor> predictors, std::span<float> material) {
  const auto differences = unpack_integers(bytes, 2 * listed.size(), 2);
  if (!differences) return false;
  for (std::size_t i = 0; i < listed.size(); ++i) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const std::uint32_t foretold = order_of(foretold_material(material, predictors[listed[i]], axis));
      const auto difference = static_cast<std::uint32_t>(unzigzag((*differences)[2 * i + axis]));
      material[2 * listed[i] + axis] = float_of(foretold + difference);
    }
  }
  return true;
}

}  // namespace kerf::codec
