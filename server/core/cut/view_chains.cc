#include "server/core/cut/view_chains.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>

namespace kerf::cut {
namespace {

constexpr std::size_t kNobody = static_cast<std::size_t>(-1);

// Returns the node of an end of an interval. Ends have numbers: interval i begins at end 2 i and ends at end 2 i + 1.
const ViewNode& node_of(const std::vector<ViewInterval>& intervals, std::size_t end) {
  const ViewInterval& interval = intervals[end / 2];
  return end % 2 == 0 ? interval.begin : interval.end;
}

std::size_t opposite(std::size_t end) {
  return end ^ 1U;
}

// Returns for each end of an interval the end of another interval that it meets, or kNobody.
std::vector<std::size_t> find_partners(const std::vector<ViewInterval>& intervals) {
  using Key = std::tuple<int, std::int32_t, std::int32_t, std::int32_t, std::size_t>;
  std::vector<Key> keys;
  for (std::size_t end = 0; end < 2 * intervals.size(); ++end) {
    const ViewNode& node = node_of(intervals, end);
    if (node.kind == ViewNode::Kind::kFree) continue;
    // Two ends meet on an edge, which a segment crosses once, or at a joint between two segments of the curve.
    const bool on_edge = node.kind == ViewNode::Kind::kEdge;
    keys.emplace_back(on_edge ? 0 : 1, node.low, node.high, on_edge ? intervals[end / 2].segment : 0, end);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::size_t> partners(2 * intervals.size(), kNobody);
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    const auto& [kind_a, low_a, high_a, segment_a, a] = keys[i];
    const auto& [kind_b, low_b, high_b, segment_b, b] = keys[i + 1];
    if (std::tie(kind_a, low_a, high_a, segment_a) != std::tie(kind_b, low_b, high_b, segment_b)) continue;
    partners[a] = b;
    partners[b] = a;
    ++i;
  }
  return partners;
}

class Linker {
 public:
  explicit Linker(const std::vector<ViewInterval>& intervals)
      : intervals_(intervals), partners_(find_partners(intervals)), done_(intervals.size()) {}

  std::vector<ViewChain> run() {
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      if (!done_[i]) chains_.push_back(follow(find_start(i)));
    }
    return std::move(chains_);
  }

 private:
  // Returns the end at which the chain through interval i starts; in a closed chain, the one where i begins.
  [[nodiscard]] std::size_t find_start(std::size_t i) const {
    std::size_t end = 2 * i;
    for (std::size_t step = 0; step < intervals_.size(); ++step) {
      const std::size_t before = partners_[end];
      if (before == kNobody) return end;
      end = opposite(before);
      if (end == 2 * i) break;
    }
    return end;
  }

  ViewChain follow(std::size_t end) {
    ViewChain chain;
    chain.first_triangle = intervals_[end / 2].triangle;
    chain.layer.nearest_m = std::numeric_limits<double>::infinity();
    append(node_of(intervals_, end), chain);
    while (end != kNobody && !done_[end / 2]) {
      done_[end / 2] = true;
      append(node_of(intervals_, opposite(end)), chain);
      end = partners_[opposite(end)];
    }
    return chain;
  }

  static void append(const ViewNode& node, ViewChain& chain) {
    chain.layer.nearest_m = std::min(chain.layer.nearest_m, node.depth);
    chain.layer.farthest_m = std::max(chain.layer.farthest_m, node.depth);
    if (!chain.points.empty()) {
      if (chain.points.back() == node.rest) return;
      chain.layer.length_m += (node.rest - chain.points.back()).norm();
    }
    chain.points.push_back(node.rest);
  }

  const std::vector<ViewInterval>& intervals_;
  std::vector<std::size_t> partners_;
  std::vector<bool> done_;
  std::vector<ViewChain> chains_;
};

}  // namespace

std::vector<ViewChain> link(const std::vector<ViewInterval>& intervals) {
  return Linker(intervals).run();
}

}  // namespace kerf::cut
