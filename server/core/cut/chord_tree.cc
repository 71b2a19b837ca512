#include "server/core/cut/chord_tree.h"

#include <algorithm>
#include <tuple>

namespace kerf::cut {

namespace {

constexpr std::int32_t kLeafChords = 8;

}  // namespace

ChordTree::ChordTree(const std::vector<Stroke>& strokes) : strokes_(strokes) {
  for (std::size_t s = 0; s < strokes.size(); ++s) {
    for (std::size_t i = 0; i + 1 < strokes[s].points.size(); ++i) {
      chords_.push_back({static_cast<std::int32_t>(s), static_cast<std::int32_t>(i)});
    }
  }
  if (!chords_.empty()) build(0, static_cast<std::int32_t>(chords_.size()));
}

Eigen::AlignedBox2d ChordTree::box_of(const Chord& chord) const {
  const std::vector<Eigen::Vector2d>& points = strokes_[static_cast<std::size_t>(chord.stroke)].points;
  Eigen::AlignedBox2d box(points[static_cast<std::size_t>(chord.index)]);
  box.extend(points[static_cast<std::size_t>(chord.index) + 1]);
  return box;
}

// Halves the chords along the longer side of their box.
void ChordTree::build(std::int32_t first, std::int32_t count) {
  const std::size_t at = nodes_.size();
  nodes_.emplace_back();
  const auto begin = chords_.begin() + first;
  Eigen::AlignedBox2d box;
  for (auto chord = begin; chord != begin + count; ++chord) box.extend(box_of(*chord));
  nodes_[at] = {box, first, count, 0};
  if (count <= kLeafChords) return;
  const int axis = box.sizes().x() >= box.sizes().y() ? 0 : 1;
  const std::int32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count, [&](const Chord& a, const Chord& b) {
    return std::tuple(box_of(a).center()[axis], a.stroke, a.index) <
           std::tuple(box_of(b).center()[axis], b.stroke, b.index);
  });
  nodes_[at].count = 0;
  build(first, half);
  nodes_[at].right = static_cast<std::int32_t>(nodes_.size());
  build(first + half, count - half);
}

void ChordTree::for_each_near(const Eigen::AlignedBox2d& box, double distance,
                              const std::function<bool(const Chord&)>& visit) const {
  if (nodes_.empty()) return;
  std::vector<std::int32_t> open{0};
  const double most = distance * distance;
  while (!open.empty()) {
    const std::int32_t at = open.back();
    const Node& node = nodes_[static_cast<std::size_t>(at)];
    open.pop_back();
    if (node.box.squaredExteriorDistance(box) > most) continue;
    if (node.count == 0) {
      open.push_back(node.right);
      open.push_back(at + 1);
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const Chord& chord = chords_[static_cast<std::size_t>(i)];
      if (box_of(chord).squaredExteriorDistance(box) <= most && !visit(chord)) return;
    }
  }
}

}  // namespace kerf::cut
