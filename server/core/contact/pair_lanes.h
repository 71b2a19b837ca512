#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/contact/feature_pair.h"

// Searches of self-contact in vector code that is chosen for the processor at run time. Results have the same bits on
// every processor. Coordinates are floats relative to the middle of the sheet.
namespace kerf::contact {

// Entries behind the last one that vector code may read.
inline constexpr std::size_t kLanePadding = 16;

// Axis-parallel boxes side by side, m.
struct BoxLanes {
  std::array<std::vector<float>, 3> low, high;

  void resize(std::size_t count);
};

// Vertices in straight motion, by vertex id.
struct MotionLanes {
  std::array<std::vector<float>, 3> x;  // m
  std::array<std::vector<float>, 3> v;  // m/s
  std::vector<float> slack;             // m, distance that a vertex may stray from its line

  void resize(std::size_t count);
};

// Pairs side by side. See FeaturePair.
struct PairLanes {
  std::vector<std::int32_t> a, b;
  std::array<std::vector<std::int32_t>, 4> vertices;

  // Sets the number of pairs, which must be set() then.
  void resize(std::size_t count);
  void set(std::size_t pair, std::int32_t feature_a, std::int32_t feature_b, const std::array<mesh::VertexId, 4>& of) {
    a[pair] = feature_a;
    b[pair] = feature_b;
    for (std::size_t i = 0; i < 4; ++i) vertices[i][pair] = of[i];
  }
  [[nodiscard]] std::size_t size() const { return a.size(); }
};

struct BoxRange {
  std::int32_t begin = 0, end = 0;
};
// A box around others, m.
struct BoxBounds {
  const float* low;
  const float* high;
};
// Appends to `found` the index pairs {i, j} of boxes that overlap, i in `range` of `boxes` and j in `other_range` of
// `others`, ascending. Boxes i are those swept along `way` (3, m). `bounds` is around all boxes j. `after`: only j > i.
void find_overlaps(const BoxLanes& boxes, BoxRange range, const float* way, const BoxLanes& others,
                   BoxRange other_range, const BoxBounds& bounds, bool after,
                   std::vector<std::array<std::int32_t, 2>>& found);

// Fills `kept` with the indices of pairs, ascending, that share no vertex and may come near within `duration` (s):
// nearer than `reach` (m) plus the slack of both sides. Sets `speeds` (m/s) to the largest relative ones of corners of
// both sides, by place in `kept`.
void find_near(FeaturePair::Kind kind, const PairLanes& pairs, const MotionLanes& motion, float duration, float reach,
               std::vector<std::int32_t>& kept, std::vector<float>& speeds);

// Bounds of how far both sides of pairs have moved against each other: on their lines, and away from them.
struct PairWays {
  std::span<const float> path;   // m, by vertex id: way relative to its line
  std::span<const float> speed;  // m/s, by pair: of lines against each other
  float elapsed = 0.0F;          // s, since the lines began
};
// Fills `due` with the indices of pairs, ascending, whose sides may have moved more than `limit` (m, by pair) against
// each other. Sets `way` (m) to how far they may have, by place in `due`. `vertices` and the storage of `limit` and
// `speed` have kLanePadding more entries than `limit`.
void find_due(const std::array<std::vector<std::int32_t>, 4>& vertices, const PairWays& ways,
              std::span<const float> limit, std::vector<std::int32_t>& due, std::vector<float>& way);

}  // namespace kerf::contact
