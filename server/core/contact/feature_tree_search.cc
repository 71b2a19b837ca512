// Members of FeatureTree that look for pairs.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/Geometry>

#include "server/core/contact/feature_tree.h"

namespace kerf::contact {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

Eigen::Vector3d flat(const Eigen::Vector2d& p) {
  return {p.x(), p.y(), 0.0};
}

}  // namespace

void FeatureTree::set_motion(VertexId v) {
  const auto i = static_cast<std::size_t>(v);
  for (std::size_t k = 0; k < 3; ++k) {
    motion_.x[k][i] = lines_[i].x[static_cast<Eigen::Index>(k)];
    motion_.v[k][i] = lines_[i].v[static_cast<Eigen::Index>(k)];
  }
}

void FeatureTree::set_lines(const Query& query) {
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
  for (const VertexId v : features_.vertices) {
    VertexLine& line = lines_[static_cast<std::size_t>(v)];
    line.x.head<3>() = (motion.x.col(v) - middle_).cast<float>();
    line.v.head<3>() = (motion.v.col(v) - drift_).cast<float>();
  }
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    const Node& node = nodes_[k];
    GradientBox box;
    if (node.right != 0) {
      box = gradients_[k + 1];
      box.add(gradients_[static_cast<std::size_t>(node.right)]);
    } else {
      for (std::int32_t t = node.begin; t < node.end; ++t) add_gradient(t, 0.0F, query.slack, box);
    }
    gradients_[k] = box;
  }
}

void FeatureTree::add_gradient(std::int32_t t, float since, std::span<const float> slack, GradientBox& box) const {
  const TriangleShape& triangle = shapes_[static_cast<std::size_t>(t)];
  std::array<const VertexLine*, 3> corners{};
  float most = 0.0F;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto v = static_cast<std::size_t>(triangle.vertices[i]);
    corners[i] = &lines_[v];
    most = std::max(most, slack[v]);
  }
  box.add(triangle, corners, since, static_cast<float>(duration_), most);
}

void FeatureTree::refit(const Query& query) {
  half_reach_ = static_cast<float>(0.5 * query.reach) + kRounding;
  for (const VertexId v : features_.vertices) {
    motion_.slack[static_cast<std::size_t>(v)] = query.slack[static_cast<std::size_t>(v)];
    since_[static_cast<std::size_t>(v)] = 0.0F;
    set_motion(v);
  }
  std::fill(is_leaf_fitted_.begin(), is_leaf_fitted_.end(), std::uint8_t{0});
  std::fill(arounds_found_.begin(), arounds_found_.end(), Around::kUnknown);
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Node& node = nodes_[k];
    if (node.right != 0) {
      const Node &left = nodes_[k + 1], &right = nodes_[static_cast<std::size_t>(node.right)];
      node.v = 0.5F * (left.v + right.v);
      node.box = left.box.swept(way_between(left, node)).united(right.box.swept(way_between(right, node)));
      continue;
    }
    const auto corners = std::span<const VertexId>(leaf_vertices_)
                             .subspan(static_cast<std::size_t>(node.first_vertex),
                                      static_cast<std::size_t>(node.end_vertex - node.first_vertex));
    node.v.setZero();
    for (const VertexId v : corners) node.v += lines_[static_cast<std::size_t>(v)].v;
    node.v /= static_cast<float>(corners.size());
    node.box = box_around(corners, node.v);
  }
}

Eigen::Array4f FeatureTree::way_between(const Node& of, const Node& in) const {
  return static_cast<float>(duration_) * (of.v - in.v);
}

FeatureTree::NodeBox FeatureTree::box_around(std::span<const VertexId> vertices, const Eigen::Array4f& frame) const {
  NodeBox box;
  const auto duration = static_cast<float>(duration_);
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const auto i = static_cast<std::size_t>(vertices[k]);
    const Eigen::Array4f u = lines_[i].v - frame, begin = lines_[i].x + since_[i] * u, end = lines_[i].x + duration * u;
    const float margin = half_reach_ + motion_.slack[i];
    const NodeBox of_vertex{begin.min(end) - margin, begin.max(end) + margin};
    box = k == 0 ? of_vertex : box.united(of_vertex);
  }
  return box;
}

void FeatureTree::set_box(std::span<const VertexId> vertices, const Node& leaf, BoxLanes& boxes, std::size_t to) const {
  const NodeBox box = box_around(vertices, leaf.v);
  for (std::size_t k = 0; k < 3; ++k) {
    boxes.low[k][to] = box.low[static_cast<Eigen::Index>(k)];
    boxes.high[k][to] = box.high[static_cast<Eigen::Index>(k)];
  }
}

void FeatureTree::fit_leaf(std::int32_t index) {
  std::uint8_t& is_fitted = is_leaf_fitted_[static_cast<std::size_t>(index)];
  if (is_fitted != 0) return;
  is_fitted = 1;
  const Node& leaf = nodes_[static_cast<std::size_t>(index)];
  const BoxRange vertices = vertices_of(leaf), edges = edges_of(leaf);
  for (auto k = static_cast<std::size_t>(vertices.begin); k < static_cast<std::size_t>(vertices.end); ++k) {
    set_box({&features_.vertices[k], 1}, leaf, vertex_boxes_, k);
  }
  for (auto t = static_cast<std::size_t>(leaf.begin); t < static_cast<std::size_t>(leaf.end); ++t) {
    set_box(features_.triangles[t].vertices, leaf, triangle_boxes_, t);
  }
  for (auto e = static_cast<std::size_t>(edges.begin); e < static_cast<std::size_t>(edges.end); ++e) {
    set_box(features_.edges[e].vertices, leaf, edge_boxes_, e);
  }
}

bool FeatureTree::is_flat(std::int32_t index) {
  Node& node = nodes_[static_cast<std::size_t>(index)];
  const std::span<const std::int32_t> others = find_cover(node.rectangle, index, node.others);
  if (node.others.kind == Cover::Kind::kBroken) return false;
  GradientBox box = gradients_[static_cast<std::size_t>(index)];
  for (const std::int32_t k : others) box.add(gradients_[static_cast<std::size_t>(k)]);
  return box.is_flat();
}

bool FeatureTree::is_flat_around(std::int32_t first, std::int32_t second) {
  Node& node = nodes_[static_cast<std::size_t>(first)];
  if (!node.around.contains(nodes_[static_cast<std::size_t>(second)].rectangle)) return false;
  Around& found = arounds_found_[static_cast<std::size_t>(first)];
  if (found == Around::kUnknown) {
    const std::span<const std::int32_t> all = find_cover(node.around, -1, node.all);
    GradientBox box;
    for (const std::int32_t k : all) box.add(gradients_[static_cast<std::size_t>(k)]);
    found = node.all.kind == Cover::Kind::kWhole && box.is_flat() ? Around::kFlat : Around::kBent;
  }
  return found == Around::kFlat;
}

void FeatureTree::find_leaf_pairs(const Query& query, std::size_t most) {
  leaf_pairs_.clear();
  is_fitted_ = false;
  if (nodes_.empty()) return;
  set_lines(query);
  if (is_flat(0)) return;
  refit(query);
  is_fitted_ = true;
  search_within(0, most);
}

bool FeatureTree::is_apart(const StraightMotion& motion, double reach, std::span<const float> slack) {
  find_leaf_pairs({motion, slack, reach}, 1);
  return leaf_pairs_.empty();
}

void FeatureTree::find_pairs(const StraightMotion& motion, double reach, std::span<const float> slack, double thickness,
                             std::vector<FeaturePair>& pairs) {
  find_overlapping({motion, slack, reach});
  keep_near(reach, thickness, pairs);
}

void FeatureTree::find_overlapping(const Query& query) {
  find_leaf_pairs(query, std::numeric_limits<std::size_t>::max());
  vertex_overlaps_.clear();
  edge_overlaps_.clear();
  for (const auto& [first, second] : leaf_pairs_) search_leaves(first, second);
}

void FeatureTree::search_within(std::int32_t index, std::size_t most) {
  if (leaf_pairs_.size() >= most || is_flat(index)) return;
  const Node& node = nodes_[static_cast<std::size_t>(index)];
  if (node.right == 0) {
    leaf_pairs_.push_back({index, index});
    return;
  }
  search_within(index + 1, most);
  search_within(node.right, most);
  search_between(index + 1, node.right, most);
}

void FeatureTree::search_between(std::int32_t first, std::int32_t second, std::size_t most) {
  const Node& a = nodes_[static_cast<std::size_t>(first)];
  const Node& b = nodes_[static_cast<std::size_t>(second)];
  if (leaf_pairs_.size() >= most || !b.box.overlaps(a.box.swept(way_between(a, b)))) return;
  if (is_flat_around(first, second) || is_flat_around(second, first)) return;
  if (a.right == 0 && b.right == 0) {
    leaf_pairs_.push_back({first, second});
  } else if (b.right == 0 || (a.right != 0 && a.end - a.begin >= b.end - b.begin)) {
    search_between(first + 1, second, most);
    search_between(a.right, second, most);
  } else {
    search_between(first, second + 1, most);
    search_between(first, b.right, most);
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

void FeatureTree::search_leaves(std::int32_t first, std::int32_t second) {
  fit_leaf(first);
  fit_leaf(second);
  const Node &a = nodes_[static_cast<std::size_t>(first)], &b = nodes_[static_cast<std::size_t>(second)];
  const Eigen::Array4f way = way_between(a, b), back = -way;
  const BoxBounds around_a{a.box.low.data(), a.box.high.data()}, around_b{b.box.low.data(), b.box.high.data()};
  find_overlaps(vertex_boxes_, vertices_of(a), way.data(), triangle_boxes_, {b.begin, b.end}, around_b, false,
                vertex_overlaps_);
  if (first != second) {
    find_overlaps(vertex_boxes_, vertices_of(b), back.data(), triangle_boxes_, {a.begin, a.end}, around_a, false,
                  vertex_overlaps_);
  }
  find_overlaps(edge_boxes_, edges_of(a), way.data(), edge_boxes_, edges_of(b), around_b, first == second,
                edge_overlaps_);
}

void FeatureTree::list_vertex_candidates() {
  candidates_.resize(vertex_overlaps_.size());
  for (std::size_t k = 0; k < vertex_overlaps_.size(); ++k) {
    const auto& [place, t] = vertex_overlaps_[k];
    const VertexId v = features_.vertices[static_cast<std::size_t>(place)];
    const std::array<VertexId, 3>& corners = shapes_[static_cast<std::size_t>(t)].vertices;
    candidates_.set(k, v, t, {v, corners[0], corners[1], corners[2]});
  }
}

void FeatureTree::list_edge_candidates() {
  candidates_.resize(edge_overlaps_.size());
  for (std::size_t k = 0; k < edge_overlaps_.size(); ++k) {
    const auto& [first, second] = edge_overlaps_[k];
    const std::array<VertexId, 2>& p = features_.edges[static_cast<std::size_t>(first)].vertices;
    const std::array<VertexId, 2>& q = features_.edges[static_cast<std::size_t>(second)].vertices;
    candidates_.set(k, first, second, {p[0], p[1], q[0], q[1]});
  }
}

template <typename Wants, typename Use>
void FeatureTree::for_near(FeaturePair::Kind kind, double reach, double thickness, const Wants& wants, const Use& use) {
  constexpr double kLeast = 0.02;  // -, of the thickness, or of the least altitude of triangles at the pair
  find_near(kind, candidates_, motion_, static_cast<float>(duration_), static_cast<float>(reach) + kRounding, near_,
            near_speeds_);
  for (std::size_t k = 0; k < near_.size(); ++k) {
    const auto p = static_cast<std::size_t>(near_[k]);
    FeaturePair pair{kind, candidates_.a[p], candidates_.b[p], {}, 0.0, 0.0, 0.0, 1.0001F * near_speeds_[k]};
    for (std::size_t i = 0; i < 4; ++i) pair.vertices[i] = candidates_.vertices[i][p];
    if (!wants(pair)) continue;
    pair.altitude = std::numeric_limits<double>::infinity();
    for (const VertexId v : pair.vertices) {
      pair.altitude = std::min(pair.altitude, features_.altitude_at[static_cast<std::size_t>(v)]);
    }
    pair.least = kLeast * std::min(thickness, pair.altitude);
    pair.thickness = std::max(half_distance_at_rest(pair, thickness), 2.0 * pair.least);
    // Small features next to each other would otherwise all be listed.
    if (pair.thickness < thickness && !comes_near(pair, reach - thickness + pair.thickness)) continue;
    use(pair);
  }
}

template <typename Wants, typename Use>
void FeatureTree::for_near(double reach, double thickness, const Wants& wants, const Use& use) {
  list_vertex_candidates();
  for_near(FeaturePair::Kind::kVertexTriangle, reach, thickness, wants, use);
  list_edge_candidates();
  for_near(FeaturePair::Kind::kEdgeEdge, reach, thickness, wants, use);
}

void FeatureTree::keep_near(double reach, double thickness, std::vector<FeaturePair>& pairs) {
  pairs.clear();
  for_near(
      reach, thickness, [](const FeaturePair&) { return true; },
      [&](const FeaturePair& pair) { pairs.push_back(pair); });
}

void FeatureTree::find_apart(const linear::VertexField& x, double reach, std::vector<std::uint8_t>& is_apart) {
  is_apart.assign(static_cast<std::size_t>(x.cols()), 1);
  const auto leave_out = [&](std::span<const VertexId> vertices) {
    for (const VertexId v : vertices) is_apart[static_cast<std::size_t>(v)] = 0;
  };
  // Lips that lie on each other were next to each other at rest.
  for (const auto& ends : features_.borders) leave_out(ends);
  const linear::VertexField still = linear::VertexField::Zero(3, x.cols());
  const std::vector<float> no_slack(static_cast<std::size_t>(x.cols()), 0.0F);
  find_overlapping({{x, still, 0.0}, no_slack, reach});
  for_near(
      reach, reach,
      [&](const FeaturePair& pair) {
        return std::any_of(pair.vertices.begin(), pair.vertices.end(),
                           [&](VertexId v) { return is_apart[static_cast<std::size_t>(v)] != 0; });
      },
      [&](const FeaturePair& pair) { leave_out(pair.vertices); });
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
