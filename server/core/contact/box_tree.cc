#include "server/core/contact/box_tree.h"

#include <array>
#include <utility>

namespace kerf::contact {
namespace {

constexpr int kKeyBits = 21;  // an axis

// Puts two zeros before each of the kKeyBits lowest bits.
std::uint64_t spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f00000000ffff;
  bits = (bits | bits << 16) & 0x001f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  return (bits | bits << 2) & 0x1249249249249249;
}

// Returns the place of a point on the curve of Morton (1966). Coordinates are in [0, 2^kKeyBits).
std::uint64_t key_of(const Eigen::Vector3d& at) {
  const auto bits = [](double x) { return spread(static_cast<std::uint64_t>(x)); };
  return bits(at.x()) | bits(at.y()) << 1 | bits(at.z()) << 2;
}

}  // namespace

void BoxTree::build(std::span<const Box> boxes) {
  Box all;
  items_.clear();
  nodes_.clear();
  order_.clear();
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if ((boxes[i].low + boxes[i].high).hasNaN()) continue;
    all.extend(boxes[i]);
    order_.push_back({0, static_cast<std::int32_t>(i)});
  }
  if (order_.empty() || !all.overlaps(all)) return;
  const double cells = ((1 << kKeyBits) - 1) / (all.high - all.low).maxCoeff();
  for (Keyed& item : order_) {
    const Box& box = boxes[static_cast<std::size_t>(item.index)];
    item.key = key_of(cells * (0.5 * (box.low + box.high) - all.low));
  }
  sort_order();
  items_.reserve(order_.size());
  for (const Keyed& item : order_) items_.push_back({boxes[static_cast<std::size_t>(item.index)], item.index});
  build_node(0, items_.size());
}

void BoxTree::sort_order() {
  constexpr std::size_t kDigitBits = 9, kDigits = 3 * kKeyBits / kDigitBits;
  constexpr std::uint64_t kMask = (1u << kDigitBits) - 1;
  std::array<std::array<std::uint32_t, kMask + 1>, kDigits> counts{};
  for (const Keyed& item : order_) {
    for (std::size_t d = 0; d < kDigits; ++d) ++counts[d][item.key >> (d * kDigitBits) & kMask];
  }
  sorted_.resize(order_.size());
  for (std::size_t d = 0; d < kDigits; ++d) {
    std::uint32_t begin = 0;
    for (std::uint32_t& count : counts[d]) begin += std::exchange(count, begin);
    for (const Keyed& item : order_) sorted_[counts[d][item.key >> (d * kDigitBits) & kMask]++] = item;
    order_.swap(sorted_);
  }
}

std::size_t BoxTree::build_node(std::size_t begin, std::size_t end) {
  const std::size_t index = nodes_.size();
  nodes_.push_back({{}, begin, end, 0});
  Box box;
  if (end - begin <= kLeaf) {
    for (std::size_t i = begin; i < end; ++i) box.extend(items_[i].box);
  } else {
    const std::size_t middle = begin + (end - begin) / 2;
    build_node(begin, middle);
    const std::size_t right = build_node(middle, end);
    nodes_[index].right = right;
    box = nodes_[index + 1].box;
    box.extend(nodes_[right].box);
  }
  nodes_[index].box = box;
  return index;
}

}  // namespace kerf::contact
