#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace kerf::contact {

// An axis-parallel box in the world; empty as made.
struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());    // m
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());  // m

  void extend(const Box& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  // Returns true if the insides of both boxes meet, along every axis. Boxes that only touch do not overlap, nor does a
  // box without an extent along an axis overlap itself.
  [[nodiscard]] bool overlaps(const Box& other) const {
    return low.x() < other.high.x() && other.low.x() < high.x() && low.y() < other.high.y() &&
           other.low.y() < high.y() && low.z() < other.high.z() && other.low.z() < high.z();
  }
};

// Finds which of many boxes overlap, by a tree of boxes around them. The boxes are put in the order of a curve that
// fills space, and halves of that order are the branches. O(n log n) if each box overlaps few others.
class BoxTree {
 public:
  // Replaces all boxes; those with a NaN are left out. Other coordinates are as orient3d() takes them. Allocates memory
  // only for more boxes than ever before.
  void build(std::span<const Box> boxes);

  // Calls found(i, j) once for each pair of boxes that overlap, by their indices, in any order.
  template <typename Found>
  void for_each_overlap(const Found& found) const {
    if (!nodes_.empty()) search_within(0, found);
  }

 private:
  static constexpr std::size_t kLeaf = 4;  // most boxes of a leaf

  struct Item {
    Box box;
    std::int32_t index = 0;  // among the boxes of build()
  };
  // A leaf holds items [begin, end); of other nodes the left child is the next one.
  struct Node {
    Box box;
    std::size_t begin = 0, end = 0;
    std::size_t right = 0;  // 0: a leaf
  };
  // A place on the curve.
  struct Keyed {
    std::uint64_t key = 0;
    std::int32_t index = 0;
  };

  // Sorts order_ by key, digit by digit.
  void sort_order();
  // Makes the node of items [begin, end) and all below it. Returns its index.
  std::size_t build_node(std::size_t begin, std::size_t end);

  template <typename Found>
  void search_within(std::size_t index, const Found& found) const {
    const Node& node = nodes_[index];
    if (!node.box.overlaps(node.box)) return;
    if (node.right != 0) {
      search_within(index + 1, found);
      search_within(node.right, found);
      search_between(index + 1, node.right, found);
      return;
    }
    for (std::size_t i = node.begin; i < node.end; ++i) {
      for (std::size_t j = i + 1; j < node.end; ++j) {
        if (items_[i].box.overlaps(items_[j].box)) found(items_[i].index, items_[j].index);
      }
    }
  }
  template <typename Found>
  void search_between(std::size_t first, std::size_t second, const Found& found) const {
    const Node &a = nodes_[first], &b = nodes_[second];
    if (!a.box.overlaps(b.box)) return;
    if (a.right != 0 && (b.right == 0 || a.end - a.begin >= b.end - b.begin)) {
      search_between(first + 1, second, found);
      search_between(a.right, second, found);
      return;
    }
    if (b.right != 0) {
      search_between(first, second + 1, found);
      search_between(first, b.right, found);
      return;
    }
    for (std::size_t i = a.begin; i < a.end; ++i) {
      if (!items_[i].box.overlaps(b.box)) continue;
      for (std::size_t j = b.begin; j < b.end; ++j) {
        if (items_[i].box.overlaps(items_[j].box)) found(items_[i].index, items_[j].index);
      }
    }
  }

  std::vector<Item> items_;   // in the order of the curve
  std::vector<Node> nodes_;   // the root first; none if no two boxes overlap
  std::vector<Keyed> order_;  // scratch of build()
  std::vector<Keyed> sorted_;
};

}  // namespace kerf::contact
