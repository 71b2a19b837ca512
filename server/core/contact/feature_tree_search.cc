// Members of FeatureTree that look for pairs.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "server/core/contact/feature_tree.h"

namespace kerf::contact {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

constexpr float kRounding = 2e-6F;  // m, of coordinates in floats

using Gradient = Eigen::Matrix<double, 3, 2>;

Gradient gradient(const SheetFeatures::Triangle& triangle, const linear::VertexField& x) {
  const Eigen::Vector3d at = x.col(triangle.vertices[0]);
  Gradient sides;
  sides.col(0) = x.col(triangle.vertices[1]) - at;
  sides.col(1) = x.col(triangle.vertices[2]) - at;
  return sides * triangle.inverse_edges;
}

double least_singular_value(const Gradient& f) {
  const double a = f.col(0).squaredNorm(), b = f.col(1).squaredNorm(), c = f.col(0).dot(f.col(1));
  const double half = 0.5 * (a + b);
  return std::sqrt(std::max(0.0, half - std::sqrt(0.25 * (a - b) * (a - b) + c * c)));
}

// Sets box `to` of `boxes` to that around some boxes of `from`.
template <std::size_t kCount>
void unite(const BoxLanes& from, const std::array<std::int32_t, kCount>& of, BoxLanes& boxes, std::size_t to) {
  for (std::size_t k = 0; k < 3; ++k) {
    float low = from.low[k][static_cast<std::size_t>(of[0])], high = from.high[k][static_cast<std::size_t>(of[0])];
    for (std::size_t i = 1; i < kCount; ++i) {
      low = std::min(low, from.low[k][static_cast<std::size_t>(of[i])]);
      high = std::max(high, from.high[k][static_cast<std::size_t>(of[i])]);
    }
    boxes.low[k][to] = low;
    boxes.high[k][to] = high;
  }
}

BoxRange range_of(std::size_t place) {
  const auto at = static_cast<std::int32_t>(place);
  return {at, at + 1};
}

Eigen::Vector3d flat(const Eigen::Vector2d& p) {
  return {p.x(), p.y(), 0.0};
}

}  // namespace

void FeatureTree::set_line(VertexId v, const Eigen::Vector3d& x, const Eigen::Vector3d& velocity, double since,
                           float margin) {
  const auto i = static_cast<std::size_t>(v);
  const auto before = static_cast<float>(since), after = static_cast<float>(duration_ - since);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    const auto at = static_cast<float>(x[axis] - middle_[axis] - since * drift_[axis]);
    const auto u = static_cast<float>(velocity[axis] - drift_[axis]);
    motion_.x[k][i] = at - before * u;
    motion_.v[k][i] = u;
    by_id_.low[k][i] = std::min(at, at + after * u) - margin;
    by_id_.high[k][i] = std::max(at, at + after * u) + margin;
  }
}

void FeatureTree::refit(const Query& query) {
  const StraightMotion& motion = query.motion;
  middle_.setZero();
  drift_.setZero();
  for (const VertexId v : features_.vertices) {
    middle_ += motion.x.col(v);
    drift_ += motion.v.col(v);
  }
  middle_ /= static_cast<double>(features_.vertices.size());
  drift_ /= static_cast<double>(features_.vertices.size());
  duration_ = motion.duration;
  const float half_reach = static_cast<float>(0.5 * query.reach) + kRounding;
  for (const VertexId v : features_.vertices) {
    const float slack = query.slack[static_cast<std::size_t>(v)];
    motion_.slack[static_cast<std::size_t>(v)] = slack;
    set_line(v, motion.x.col(v), motion.v.col(v), 0.0, half_reach + slack);
  }
  for (std::size_t k = 0; k < features_.vertices.size(); ++k) {
    unite<1>(by_id_, {features_.vertices[k]}, vertex_boxes_, k);
  }
  for (std::size_t t = 0; t < features_.triangles.size(); ++t) {
    unite(by_id_, features_.triangles[t].vertices, triangle_boxes_, t);
  }
  for (std::size_t e = 0; e < features_.edges.size(); ++e) unite(by_id_, features_.edges[e].vertices, edge_boxes_, e);
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    NodeBox& box = nodes_[k].box;
    if (nodes_[k].right != 0) {
      const NodeBox &left = nodes_[k + 1].box, &right = nodes_[static_cast<std::size_t>(nodes_[k].right)].box;
      box = {left.low.min(right.low), left.high.max(right.high)};
      continue;
    }
    box = NodeBox();
    const auto begin = static_cast<std::ptrdiff_t>(nodes_[k].begin), end = static_cast<std::ptrdiff_t>(nodes_[k].end);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto axis = static_cast<Eigen::Index>(c);
      box.low[axis] = *std::min_element(triangle_boxes_.low[c].begin() + begin, triangle_boxes_.low[c].begin() + end);
      box.high[axis] =
          *std::max_element(triangle_boxes_.high[c].begin() + begin, triangle_boxes_.high[c].begin() + end);
    }
  }
}

bool FeatureTree::is_flat(const Node& node, const Query& query) const {
  // -, shares of a distance at rest that must be left; the second one is for vertices that stray by their slack.
  constexpr double kLeast = 0.05;
  constexpr double kStray = 2.4;
  constexpr std::int32_t kSamples = 8;
  const StraightMotion& motion = query.motion;
  const std::int32_t count = node.end - node.begin;
  Gradient middle = Gradient::Zero(), turn = Gradient::Zero();
  for (std::int32_t k = 0; k < kSamples; ++k) {
    const auto t = static_cast<std::size_t>(node.begin + (2 * k + 1) * count / (2 * kSamples));
    middle += gradient(features_.triangles[t], motion.x) / kSamples;
    turn += gradient(features_.triangles[t], motion.v) / kSamples;
  }
  middle += 0.5 * motion.duration * turn;
  const double room = least_singular_value(middle) - kLeast;
  const auto is_near = [&](std::int32_t t) {
    const SheetFeatures::Triangle& triangle = features_.triangles[static_cast<std::size_t>(t)];
    float slack = 0.0F;
    for (const VertexId v : triangle.vertices) slack = std::max(slack, query.slack[static_cast<std::size_t>(v)]);
    const double allowed = room - kStray * static_cast<double>(slack) / triangle.altitude;
    if (!(allowed > 0.0)) return false;
    const Gradient first = gradient(triangle, motion.x) - middle;
    const Gradient last = first + motion.duration * gradient(triangle, motion.v);
    return first.squaredNorm() <= allowed * allowed && last.squaredNorm() <= allowed * allowed;
  };
  for (std::int32_t t = node.begin; t < node.end; ++t) {
    if (!is_near(t)) return false;
  }
  for (std::int32_t k = node.first_other; k < node.end_other; ++k) {
    if (!is_near(others_[static_cast<std::size_t>(k)])) return false;
  }
  return true;
}

void FeatureTree::find_pairs(const StraightMotion& motion, double reach, std::span<const float> slack, double thickness,
                             std::vector<FeaturePair>& pairs) {
  pairs.clear();
  is_fitted_ = false;
  if (nodes_.empty()) return;
  const Query query{motion, slack, reach};
  if (nodes_[0].is_whole && is_flat(nodes_[0], query)) return;
  refit(query);
  is_fitted_ = true;
  vertex_candidates_.clear();
  edge_candidates_.clear();
  search_within(0, query);
  vertex_candidates_.pad();
  edge_candidates_.pad();
  keep_near(FeaturePair::Kind::kVertexTriangle, vertex_candidates_, reach, thickness, pairs);
  keep_near(FeaturePair::Kind::kEdgeEdge, edge_candidates_, reach, thickness, pairs);
}

void FeatureTree::refit_around(std::span<const VertexId> strayed) {
  strayed_triangles_.clear();
  strayed_edges_.clear();
  const auto add = [](std::int32_t index, std::vector<std::uint8_t>& is_listed, std::vector<std::int32_t>& list) {
    std::uint8_t& listed = is_listed[static_cast<std::size_t>(index)];
    if (listed == 0) list.push_back(index);
    listed = 1;
  };
  for (const VertexId v : strayed) {
    is_strayed_[static_cast<std::size_t>(v)] = 1;
    unite<1>(by_id_, {v}, vertex_boxes_, static_cast<std::size_t>(place_[static_cast<std::size_t>(v)]));
    for (const std::int32_t t : features_.triangles_of(v)) add(t, is_strayed_triangle_, strayed_triangles_);
    for (const std::int32_t e : features_.edges_of(v)) add(e, is_strayed_edge_, strayed_edges_);
  }
  for (const std::int32_t e : strayed_edges_) {
    unite(by_id_, features_.edges[static_cast<std::size_t>(e)].vertices, edge_boxes_, static_cast<std::size_t>(e));
  }
  for (const std::int32_t t : strayed_triangles_) {
    const auto i = static_cast<std::size_t>(t);
    unite(by_id_, features_.triangles[i].vertices, triangle_boxes_, i);
    const NodeBox box = box_of(triangle_boxes_, i);
    for (std::int32_t k = leaf_of_[i]; k >= 0; k = parent_[static_cast<std::size_t>(k)]) {
      NodeBox& around = nodes_[static_cast<std::size_t>(k)].box;
      if ((around.low <= box.low).all() && (around.high >= box.high).all()) break;
      around = {around.low.min(box.low), around.high.max(box.high)};
    }
  }
}

template <typename Visit>
void FeatureTree::for_each_leaf(const NodeBox& box, const Visit& visit) {
  stack_.assign(1, 0);
  while (!stack_.empty()) {
    const std::int32_t k = stack_.back();
    stack_.pop_back();
    const Node& node = nodes_[static_cast<std::size_t>(k)];
    if (!node.box.overlaps(box)) continue;
    if (node.right == 0) {
      visit(node);
    } else {
      stack_.push_back(node.right);
      stack_.push_back(k + 1);
    }
  }
}

void FeatureTree::follow(std::span<const VertexId> strayed, const linear::VertexField& x, const linear::VertexField& v,
                         double since, double reach, std::span<const float> slack, double thickness,
                         std::vector<FeaturePair>& pairs) {
  pairs.clear();
  vertex_candidates_.clear();
  edge_candidates_.clear();
  const float half_reach = static_cast<float>(0.5 * reach) + kRounding;
  for (const VertexId i : strayed) {
    const float of_vertex = slack[static_cast<std::size_t>(i)];
    motion_.slack[static_cast<std::size_t>(i)] = of_vertex;
    set_line(i, x.col(i) + since * v.col(i), v.col(i), since, half_reach + of_vertex);
  }
  refit_around(strayed);
  for (const VertexId of : strayed) {
    const auto place = static_cast<std::size_t>(place_[static_cast<std::size_t>(of)]);
    for_each_leaf(box_of(vertex_boxes_, place), [&](const Node& leaf) {
      overlaps_.clear();
      find_overlaps(vertex_boxes_, range_of(place), triangle_boxes_, {leaf.begin, leaf.end}, false, overlaps_);
      for (const auto& [k, t] : overlaps_) add_vertex_candidate(of, t);
    });
  }
  for (const std::int32_t t : strayed_triangles_) {
    const auto place = static_cast<std::size_t>(t);
    for_each_leaf(box_of(triangle_boxes_, place), [&](const Node& leaf) {
      overlaps_.clear();
      find_overlaps(triangle_boxes_, range_of(place), vertex_boxes_, vertices_of(leaf), false, overlaps_);
      for (const auto& [k, i] : overlaps_) {
        const VertexId of = features_.vertices[static_cast<std::size_t>(i)];
        if (is_strayed_[static_cast<std::size_t>(of)] == 0) add_vertex_candidate(of, t);
      }
    });
  }
  for (const std::int32_t e : strayed_edges_) {
    const auto place = static_cast<std::size_t>(e);
    for_each_leaf(box_of(edge_boxes_, place), [&](const Node& leaf) {
      overlaps_.clear();
      find_overlaps(edge_boxes_, range_of(place), edge_boxes_, edges_of(leaf), false, overlaps_);
      for (const auto& [k, i] : overlaps_) {
        // Two edges at strayed vertices find each other.
        if (i != e && (i > e || is_strayed_edge_[static_cast<std::size_t>(i)] == 0)) {
          add_edge_candidate(std::min(e, i), std::max(e, i));
        }
      }
    });
  }
  for (const VertexId of : strayed) is_strayed_[static_cast<std::size_t>(of)] = 0;
  for (const std::int32_t t : strayed_triangles_) is_strayed_triangle_[static_cast<std::size_t>(t)] = 0;
  for (const std::int32_t e : strayed_edges_) is_strayed_edge_[static_cast<std::size_t>(e)] = 0;
  vertex_candidates_.pad();
  edge_candidates_.pad();
  keep_near(FeaturePair::Kind::kVertexTriangle, vertex_candidates_, reach, thickness, pairs);
  keep_near(FeaturePair::Kind::kEdgeEdge, edge_candidates_, reach, thickness, pairs);
}

void FeatureTree::search_within(std::int32_t index, const Query& query) {
  const Node& node = nodes_[static_cast<std::size_t>(index)];
  if (node.is_whole && is_flat(node, query)) return;
  if (node.right == 0) {
    search_leaves(node, node);
    return;
  }
  search_within(index + 1, query);
  search_within(node.right, query);
  search_between(index + 1, node.right);
}

void FeatureTree::search_between(std::int32_t first, std::int32_t second) {
  const Node& a = nodes_[static_cast<std::size_t>(first)];
  const Node& b = nodes_[static_cast<std::size_t>(second)];
  if (!a.box.overlaps(b.box)) return;
  if (a.right == 0 && b.right == 0) {
    search_leaves(a, b);
  } else if (b.right == 0 || (a.right != 0 && a.end - a.begin >= b.end - b.begin)) {
    search_between(first + 1, second);
    search_between(a.right, second);
  } else {
    search_between(first, second + 1);
    search_between(first, b.right);
  }
}

BoxRange FeatureTree::vertices_of(const Node& node) const {
  return {features_.first_vertex[static_cast<std::size_t>(node.begin)],
          features_.first_vertex[static_cast<std::size_t>(node.end)]};
}

BoxRange FeatureTree::edges_of(const Node& node) const {
  return {features_.first_edge[static_cast<std::size_t>(node.begin)],
          features_.first_edge[static_cast<std::size_t>(node.end)]};
}

void FeatureTree::add_vertex_candidate(VertexId v, std::int32_t triangle) {
  const std::array<VertexId, 3>& corners = features_.triangles[static_cast<std::size_t>(triangle)].vertices;
  vertex_candidates_.add(v, triangle, {v, corners[0], corners[1], corners[2]});
}

void FeatureTree::add_edge_candidate(std::int32_t first, std::int32_t second) {
  const std::array<VertexId, 2>& p = features_.edges[static_cast<std::size_t>(first)].vertices;
  const std::array<VertexId, 2>& q = features_.edges[static_cast<std::size_t>(second)].vertices;
  edge_candidates_.add(first, second, {p[0], p[1], q[0], q[1]});
}

void FeatureTree::search_leaves(const Node& a, const Node& b) {
  overlaps_.clear();
  find_overlaps(vertex_boxes_, vertices_of(a), triangle_boxes_, {b.begin, b.end}, false, overlaps_);
  if (&a != &b) find_overlaps(vertex_boxes_, vertices_of(b), triangle_boxes_, {a.begin, a.end}, false, overlaps_);
  for (const auto& [k, t] : overlaps_) add_vertex_candidate(features_.vertices[static_cast<std::size_t>(k)], t);
  overlaps_.clear();
  find_overlaps(edge_boxes_, edges_of(a), edge_boxes_, edges_of(b), &a == &b, overlaps_);
  for (const auto& [i, j] : overlaps_) add_edge_candidate(i, j);
}

void FeatureTree::keep_near(FeaturePair::Kind kind, const PairLanes& candidates, double reach, double thickness,
                            std::vector<FeaturePair>& pairs) {
  constexpr double kLeast = 0.02;  // -, of the thickness, or of the least altitude of triangles at the pair
  find_near(kind, candidates, motion_, static_cast<float>(duration_), static_cast<float>(reach) + kRounding, near_);
  for (const std::int32_t k : near_) {
    const auto p = static_cast<std::size_t>(k);
    FeaturePair pair{kind, candidates.a[p], candidates.b[p], {}, 0.0, 0.0};
    double altitude = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {
      pair.vertices[i] = candidates.vertices[i][p];
      altitude = std::min(altitude, features_.altitude_at[static_cast<std::size_t>(pair.vertices[i])]);
    }
    pair.least = kLeast * std::min(thickness, altitude);
    pair.thickness = std::max(half_distance_at_rest(pair, thickness), 2.0 * pair.least);
    // Small features next to each other would otherwise all be listed.
    if (pair.thickness < thickness && !comes_near(pair, reach - thickness + pair.thickness)) continue;
    pairs.push_back(pair);
  }
}

bool FeatureTree::comes_near(const FeaturePair& pair, double reach) const {
  PairPositions x, v;
  std::array<double, 2> slack{};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto id = static_cast<std::size_t>(pair.vertices[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      x[i][static_cast<Eigen::Index>(k)] = static_cast<double>(motion_.x[k][id]);
      v[i][static_cast<Eigen::Index>(k)] = static_cast<double>(motion_.v[k][id]);
    }
    double& of_side = slack[i < pair.num_a() ? 0 : 1];
    of_side = std::max(of_side, static_cast<double>(motion_.slack[id]));
  }
  double fastest = 0.0;  // m/s
  for (std::size_t i = 0; i < pair.num_a(); ++i) {
    for (std::size_t j = pair.num_a(); j < 4; ++j) fastest = std::max(fastest, (v[i] - v[j]).norm());
  }
  return separation(pair.kind, x).distance < reach + slack[0] + slack[1] + duration_ * fastest;
}

double FeatureTree::half_distance_at_rest(const FeaturePair& pair, double most) const {
  Eigen::AlignedBox2d a, b;
  PairPositions at;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d& p = features_.material[static_cast<std::size_t>(pair.vertices[i])];
    at[i] = flat(p);
    (i < pair.num_a() ? a : b).extend(p);
  }
  if (a.squaredExteriorDistance(b) >= 4.0 * most * most) return most;
  return std::min(most, 0.5 * separation(pair.kind, at).distance);
}

}  // namespace kerf::contact
