#include "server/core/cut/view_layers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "server/base/sort_unique.h"

namespace kerf::cut {
namespace {

constexpr double kSameDepth = 1.0e-9;      // -; relative difference below which two layers lie on each other
constexpr int kMaxHalvings = 24;           // most halvings of a stretch in which layers pass through each other
constexpr double kShortestStretch = 1e-9;  // -; fraction of a segment below which a stretch is not halved

// Returns the point of the interval at parameter `at` of its segment, begin.at <= at <= end.at.
ViewNode node_at(const ViewInterval& interval, double at) {
  const ViewNode& a = interval.begin;
  const ViewNode& b = interval.end;
  const double share = b.at > a.at ? (at - a.at) / (b.at - a.at) : 0.0;
  ViewNode node;
  node.at = at;
  node.inverse_w = (1.0 - share) * a.inverse_w + share * b.inverse_w;
  const double of_b = share * b.inverse_w / node.inverse_w;
  node.rest = (1.0 - of_b) * a.rest + of_b * b.rest;
  node.depth = (1.0 - of_b) * a.depth + of_b * b.depth;
  return node;
}

// Returns the part of the interval from `from` to `to` (parameters of its segment). At the interval's own ends it keeps
// the interval's nodes.
ViewInterval part_of(const ViewInterval& interval, double from, double to) {
  ViewInterval part = interval;
  if (from > interval.begin.at) part.begin = node_at(interval, from);
  if (to < interval.end.at) part.end = node_at(interval, to);
  return part;
}

bool is_same_node(const ViewNode& a, const ViewNode& b) {
  return a.kind == b.kind && a.kind != ViewNode::Kind::kFree && a.low == b.low && a.high == b.high;
}

// Finds the nearest layer along one segment.
class NearestLayer {
 public:
  explicit NearestLayer(std::vector<ViewInterval>& seen) : seen_(seen) {}

  // Appends the nearest layer along one segment to `seen`. `first` to `last`: the intervals of the segment, sorted by
  // begin.at.
  void run(const ViewInterval* first, const ViewInterval* last) {
    std::vector<double> stops;
    for (const ViewInterval* i = first; i != last; ++i) {
      stops.push_back(i->begin.at);
      stops.push_back(i->end.at);
    }
    sort_unique(stops);
    active_.clear();
    const ViewInterval* next = first;
    for (std::size_t s = 0; s + 1 < stops.size(); ++s) {
      std::erase_if(active_, [&](const ViewInterval* i) { return i->end.at <= stops[s]; });
      for (; next != last && next->begin.at <= stops[s]; ++next) {
        if (next->end.at > stops[s]) active_.push_back(next);
      }
      if (!active_.empty()) cover(stops[s], stops[s + 1], 0);
    }
  }

 private:
  // Returns the active interval that is seen at `at`. Among coincident layers it is the one seen just before, so that
  // rounding does not make the cut jump between them.
  [[nodiscard]] const ViewInterval* nearest(double at) const {
    double least = std::numeric_limits<double>::infinity();
    for (const ViewInterval* i : active_) least = std::min(least, node_at(*i, at).depth);
    const double limit = least + kSameDepth * (1.0 + std::abs(least));
    const ViewInterval* found = nullptr;
    for (const ViewInterval* i : active_) {
      if (node_at(*i, at).depth > limit) continue;
      if (!seen_.empty() && continues(*i)) return i;
      if (found == nullptr || i->triangle < found->triangle) found = i;
    }
    return found;
  }

  [[nodiscard]] bool continues(const ViewInterval& interval) const {
    const ViewInterval& last = seen_.back();
    const bool same = interval.triangle == last.triangle && interval.segment == last.segment;
    return same || is_same_node(interval.begin, last.end);
  }

  void cover(double from, double to, int halvings) {
    const double inset = 1.0e-3 * (to - from);
    const double middle = 0.5 * (from + to);
    const ViewInterval* at_begin = nearest(from + inset);
    if (at_begin == nearest(middle) && at_begin == nearest(to - inset)) return show(*at_begin, from, to);
    if (halvings == kMaxHalvings || to - from < kShortestStretch) return show(*at_begin, from, to);
    cover(from, middle, halvings + 1);
    cover(middle, to, halvings + 1);
  }

  void show(const ViewInterval& interval, double from, double to) {
    if (!seen_.empty()) {
      ViewInterval& last = seen_.back();
      if (last.triangle == interval.triangle && last.segment == interval.segment && last.end.at == from) {
        last = part_of(interval, last.begin.at, to);
        return;
      }
    }
    seen_.push_back(part_of(interval, from, to));
  }

  std::vector<ViewInterval>& seen_;
  std::vector<const ViewInterval*> active_;
};

// Adds intervals of no length that continue one that is seen. Beside a vertex the curve may run through triangles in
// stretches too short for a double. They hide nothing, but they join the intervals on both sides.
void add_points(const std::vector<ViewInterval>& intervals, std::vector<ViewInterval>& seen) {
  using Key = std::tuple<std::int32_t, std::int32_t, std::int32_t>;
  std::multimap<Key, const ViewInterval*> points;
  const auto key = [](const ViewInterval& interval, const ViewNode& node) {
    return Key{interval.segment, node.low, node.high};
  };
  for (const ViewInterval& i : intervals) {
    if (i.begin.at < i.end.at) continue;
    for (const ViewNode* node : {&i.begin, &i.end}) {
      if (node->kind == ViewNode::Kind::kEdge) points.emplace(key(i, *node), &i);
    }
  }
  if (points.empty()) return;
  for (std::size_t s = 0; s < seen.size(); ++s) {  // `seen` grows meanwhile
    const ViewInterval from = seen[s];
    for (const ViewNode* node : {&from.begin, &from.end}) {
      if (node->kind != ViewNode::Kind::kEdge) continue;
      for (auto found = points.find(key(from, *node)); found != points.end(); found = points.find(key(from, *node))) {
        const ViewInterval& point = *found->second;
        std::erase_if(points, [&](const auto& entry) { return entry.second == &point; });
        seen.push_back(point);
      }
    }
  }
  std::stable_sort(seen.begin(), seen.end(), [](const ViewInterval& a, const ViewInterval& b) {
    return std::tie(a.segment, a.begin.at) < std::tie(b.segment, b.begin.at);
  });
}

std::vector<ViewInterval> nearest_layer(const std::vector<ViewInterval>& intervals) {
  std::vector<ViewInterval> seen;
  NearestLayer layer(seen);
  const ViewInterval* const end = intervals.data() + intervals.size();
  for (const ViewInterval* first = intervals.data(); first != end;) {
    const ViewInterval* last = first;
    while (last != end && last->segment == first->segment) ++last;
    layer.run(first, last);
    first = last;
  }
  add_points(intervals, seen);
  return seen;
}

// Returns the fraction of the interval at which the depth is `depth`. Interpolates 1 / w and depth / w, which are
// linear.
double share_at_depth(const ViewInterval& interval, double depth) {
  const double a = (interval.begin.depth - depth) * interval.begin.inverse_w;
  const double b = (interval.end.depth - depth) * interval.end.inverse_w;
  return a / (a - b);
}

// Shortens the interval to the range of depths; returns false if nothing is left.
bool clip_depth(ViewInterval& interval, double nearest, double farthest) {
  double from = interval.begin.at;
  double to = interval.end.at;
  const double length = to - from;
  for (const auto& [depth, sense] : {std::pair{nearest, 1.0}, std::pair{farthest, -1.0}}) {
    const bool begin_in = sense * (interval.begin.depth - depth) >= 0.0;
    const bool end_in = sense * (interval.end.depth - depth) >= 0.0;
    if (!begin_in && !end_in) return false;
    if (begin_in && end_in) continue;
    const double at = interval.begin.at + std::clamp(share_at_depth(interval, depth), 0.0, 1.0) * length;
    if (!begin_in) from = std::max(from, at);
    if (!end_in) to = std::min(to, at);
  }
  if (from > to) return false;
  interval = part_of(interval, from, to);
  return true;
}

}  // namespace

std::vector<ViewInterval> select_layers(const mesh::TriangleMesh& mesh, const View& view,
                                        std::vector<ViewInterval> intervals) {
  switch (view.layers) {
    case LayerRule::kAll:
      break;
    case LayerRule::kNearest:
      return nearest_layer(intervals);
    case LayerRule::kPiece: {
      std::int32_t piece = view.piece;
      if (piece == mesh::kNone && !intervals.empty()) piece = mesh.piece(nearest_layer(intervals).front().triangle);
      std::erase_if(intervals, [&](const ViewInterval& i) { return mesh.piece(i.triangle) != piece; });
      break;
    }
    case LayerRule::kDepthRange:
      std::erase_if(intervals, [&](ViewInterval& i) { return !clip_depth(i, view.nearest_m, view.farthest_m); });
      break;
  }
  return intervals;
}

bool faces_camera(const mesh::TriangleMesh& mesh, const Screen& screen, mesh::TriangleId triangle) {
  const auto& v = mesh.vertices(triangle);
  const auto at = [&](std::size_t k) { return screen.vertices[static_cast<std::size_t>(v[k])].at; };
  return mesh::orient2d(at(0), at(1), at(2)) < 0;  // y points down
}

}  // namespace kerf::cut
