#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kerf::mesh {

// Finds the boxes of a set that intersect a given box. Costs O(log n + number found) if the boxes are spread out.
class BoxTree {
 public:
  explicit BoxTree(std::vector<Eigen::AlignedBox2d> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    if (!boxes_.empty()) build(0, static_cast<std::int32_t>(boxes_.size()));
  }

  // Calls visit(index) for each box that has a point in common with `box`, until one call returns false. Returns true
  // if none did.
  template <typename Visit>
  [[nodiscard]] bool visit_meeting(const Eigen::AlignedBox2d& box, const Visit& visit) const {
    return nodes_.empty() || descend(0, box, visit);
  }

 private:
  struct Node {
    Eigen::AlignedBox2d box;
    std::int32_t begin = 0, end = 0;  // range in order_, the whole branch
    std::int32_t right = -1;          // index of the right child, -1 in a leaf; the left child is the next node
  };
  static constexpr std::int32_t kLeafBoxes = 8;

  std::int32_t build(std::int32_t begin, std::int32_t end) {
    const auto index = static_cast<std::int32_t>(nodes_.size());
    Node node;
    node.begin = begin, node.end = end;
    for (std::int32_t i = begin; i < end; ++i) node.box.extend(boxes_[order_[i]]);
    nodes_.push_back(node);
    if (end - begin <= kLeafBoxes) return index;
    const Eigen::Vector2d sizes = node.box.sizes();
    const int axis = sizes.x() >= sizes.y() ? 0 : 1;
    const auto middle_of = [&](std::int32_t i) { return boxes_[i].min()[axis] + boxes_[i].max()[axis]; };
    const std::int32_t middle = begin + (end - begin) / 2;
    std::nth_element(
        order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
        [&](std::int32_t i, std::int32_t j) { return std::pair(middle_of(i), i) < std::pair(middle_of(j), j); });
    build(begin, middle);
    const std::int32_t right = build(middle, end);
    nodes_[index].right = right;
    return index;
  }

  template <typename Visit>
  [[nodiscard]] bool descend(std::int32_t index, const Eigen::AlignedBox2d& box, const Visit& visit) const {
    const Node& node = nodes_[index];
    if (!node.box.intersects(box)) return true;
    if (node.right >= 0) return descend(index + 1, box, visit) && descend(node.right, box, visit);
    for (std::int32_t i = node.begin; i < node.end; ++i) {
      if (boxes_[order_[i]].intersects(box) && !visit(order_[i])) return false;
    }
    return true;
  }

  std::vector<Eigen::AlignedBox2d> boxes_;
  std::vector<std::int32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace kerf::mesh
