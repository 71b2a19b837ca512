#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/core/cut/curve.h"

namespace kerf::cut {

// The straight pieces of many strokes, ordered by place. Finds those near a place without looking at all.
class ChordTree {
 public:
  // Chord `index` of a stroke runs from its point `index` to the next one.
  struct Chord {
    std::int32_t stroke = 0;
    std::int32_t index = 0;
  };

  explicit ChordTree(const std::vector<Stroke>& strokes);

  // Calls `visit` with each chord whose box comes closer to `box` than `distance` (m), until it returns false.
  void for_each_near(const Eigen::AlignedBox2d& box, double distance,
                     const std::function<bool(const Chord&)>& visit) const;

 private:
  struct Node {
    Eigen::AlignedBox2d box;
    std::int32_t first = 0;  // of a leaf: its first chord
    std::int32_t count = 0;  // of a leaf: its chords; 0: it has two children, the next node and `right`
    std::int32_t right = 0;
  };

  void build(std::int32_t first, std::int32_t count);
  [[nodiscard]] Eigen::AlignedBox2d box_of(const Chord& chord) const;

  const std::vector<Stroke>& strokes_;
  std::vector<Chord> chords_;
  std::vector<Node> nodes_;
};

}  // namespace kerf::cut
