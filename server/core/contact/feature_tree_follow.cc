// Members of FeatureTree that look for the pairs of vertices which left their lines.
#include <algorithm>

#include "server/core/contact/feature_tree.h"

namespace kerf::contact {

using mesh::VertexId;

namespace {

std::span<const std::int32_t> of_range(const std::vector<std::int32_t>& list, BoxRange range) {
  return std::span<const std::int32_t>(list).subspan(static_cast<std::size_t>(range.begin),
                                                     static_cast<std::size_t>(range.end - range.begin));
}

}  // namespace

void FeatureTree::set_line(VertexId v, const Eigen::Vector3d& x, const Eigen::Vector3d& velocity, double since) {
  const auto i = static_cast<std::size_t>(v);
  VertexLine& line = lines_[i];
  line.v.head<3>() = (velocity - drift_).cast<float>();
  line.x.head<3>() = (x - middle_ - since * drift_).cast<float>();
  line.x -= static_cast<float>(since) * line.v;
  since_[i] = static_cast<float>(since);
  set_motion(v);
}

void FeatureTree::refit_nodes(std::int32_t leaf, NodeBox box) {
  for (std::int32_t k = leaf; k >= 0;) {
    Node& node = nodes_[static_cast<std::size_t>(k)];
    if ((node.box.low <= box.low).all() && (node.box.high >= box.high).all()) break;
    node.box = node.box.united(box);
    k = parent_[static_cast<std::size_t>(k)];
    if (k >= 0) box = box.swept(way_between(node, nodes_[static_cast<std::size_t>(k)]));
  }
}

void FeatureTree::refit_around(std::span<const VertexId> strayed) {
  strayed_triangles_.clear();
  strayed_edges_.clear();
  groups_.clear();
  const auto add = [](std::span<const std::int32_t> indices, std::vector<std::uint8_t>& is_listed,
                      std::vector<std::int32_t>& list) {
    const auto begin = static_cast<std::int32_t>(list.size());
    for (const std::int32_t index : indices) {
      std::uint8_t& listed = is_listed[static_cast<std::size_t>(index)];
      if (listed == 0) list.push_back(index);
      listed = 1;
    }
    return BoxRange{begin, static_cast<std::int32_t>(list.size())};
  };
  for (const VertexId v : strayed) {
    is_strayed_[static_cast<std::size_t>(v)] = 1;
    const std::int32_t place = place_[static_cast<std::size_t>(v)];
    set_box({&v, 1}, leaf_at(leaf_of_vertex_, place), vertex_boxes_, static_cast<std::size_t>(place));
    groups_.push_back({v, add(features_.triangles_of(v), is_strayed_triangle_, strayed_triangles_),
                       add(features_.edges_of(v), is_strayed_edge_, strayed_edges_)});
  }
  for (const std::int32_t e : strayed_edges_) {
    const auto i = static_cast<std::size_t>(e);
    set_box(features_.edges[i].vertices, leaf_at(leaf_of_edge_, e), edge_boxes_, i);
  }
  for (const std::int32_t t : strayed_triangles_) {
    const auto i = static_cast<std::size_t>(t);
    set_box(features_.triangles[i].vertices, leaf_at(leaf_of_, t), triangle_boxes_, i);
    refit_nodes(leaf_of_[i], box_of(triangle_boxes_, t));
  }
}

void FeatureTree::extend_gradients(std::int32_t t, float since, std::span<const float> slack) {
  GradientBox box;
  add_gradient(t, since, slack, box);
  for (std::int32_t k = leaf_of_[static_cast<std::size_t>(t)]; k >= 0; k = parent_[static_cast<std::size_t>(k)]) {
    gradients_[static_cast<std::size_t>(k)].add(box);
  }
}

bool FeatureTree::is_within_around(const StrayedGroup& group, const Node& home) const {
  const auto is_inside = [&](VertexId v) {
    return home.around.contains(features_.material[static_cast<std::size_t>(v)]);
  };
  for (std::int32_t k = group.triangles.begin; k < group.triangles.end; ++k) {
    const std::int32_t t = strayed_triangles_[static_cast<std::size_t>(k)];
    const auto& corners = features_.triangles[static_cast<std::size_t>(t)].vertices;
    if (!std::all_of(corners.begin(), corners.end(), is_inside)) return false;
  }
  for (std::int32_t k = group.edges.begin; k < group.edges.end; ++k) {
    const std::int32_t e = strayed_edges_[static_cast<std::size_t>(k)];
    const auto& ends = features_.edges[static_cast<std::size_t>(e)].vertices;
    if (!std::all_of(ends.begin(), ends.end(), is_inside)) return false;
  }
  return is_inside(group.vertex);
}

void FeatureTree::find_leaves(const NodeBox& box, std::int32_t home, bool may_skip) {
  const Node& of = nodes_[static_cast<std::size_t>(home)];
  leaves_.clear();
  visit_down(nodes_, stack_, [&](std::int32_t k) {
    const Node& node = nodes_[static_cast<std::size_t>(k)];
    if (!node.box.overlaps(box.swept(way_between(of, node)))) return false;
    if (may_skip && is_flat_around(home, k)) return false;
    if (node.right != 0) return true;
    fit_leaf(k);
    leaves_.push_back(k);
    return false;
  });
}

void FeatureTree::follow_group(const StrayedGroup& group) {
  const std::int32_t place = place_[static_cast<std::size_t>(group.vertex)];
  const std::int32_t home_index = leaf_of_vertex_[static_cast<std::size_t>(place)];
  const Node& home = nodes_[static_cast<std::size_t>(home_index)];
  group_boxes_.clear();
  NodeBox around = box_of(vertex_boxes_, place);
  const auto add = [&](const BoxLanes& boxes, std::int32_t index, const Node& leaf) {
    group_boxes_.push_back(box_of(boxes, index).swept(way_between(leaf, home)));
    around = around.united(group_boxes_.back());
  };
  add(vertex_boxes_, place, home);
  for (const std::int32_t t : of_range(strayed_triangles_, group.triangles))
    add(triangle_boxes_, t, leaf_at(leaf_of_, t));
  for (const std::int32_t e : of_range(strayed_edges_, group.edges)) add(edge_boxes_, e, leaf_at(leaf_of_edge_, e));
  find_leaves(around, home_index, is_within_around(group, home));
  for (const std::int32_t k : leaves_) {
    const Node& leaf = nodes_[static_cast<std::size_t>(k)];
    const NodeBox box = leaf.box.swept(way_between(leaf, home));
    const NodeBox* of_feature = group_boxes_.data();
    // Calls visit(i) for the boxes i of `others` that overlap that of a feature of the group.
    const auto for_overlaps = [&](const BoxLanes& boxes, std::int32_t index, const Node& of, const BoxLanes& others,
                                  BoxRange range, const auto& visit) {
      if (!(of_feature++)->overlaps(box)) return;
      overlaps_.clear();
      find_overlaps(boxes, {index, index + 1}, way_between(of, leaf).data(), others, range,
                    {leaf.box.low.data(), leaf.box.high.data()}, false, overlaps_);
      for (const auto& [i, other] : overlaps_) visit(other);
    };
    for_overlaps(vertex_boxes_, place, home, triangle_boxes_, {leaf.begin, leaf.end}, [&](std::int32_t t) {
      vertex_overlaps_.push_back({place, t});
    });
    for (const std::int32_t t : of_range(strayed_triangles_, group.triangles)) {
      for_overlaps(triangle_boxes_, t, leaf_at(leaf_of_, t), vertex_boxes_, vertices_of(leaf), [&](std::int32_t at) {
        const VertexId v = features_.vertices[static_cast<std::size_t>(at)];
        if (is_strayed_[static_cast<std::size_t>(v)] == 0) vertex_overlaps_.push_back({at, t});
      });
    }
    for (const std::int32_t e : of_range(strayed_edges_, group.edges)) {
      for_overlaps(edge_boxes_, e, leaf_at(leaf_of_edge_, e), edge_boxes_, edges_of(leaf), [&](std::int32_t other) {
        // Two edges at strayed vertices find each other.
        if (other != e && (other > e || is_strayed_edge_[static_cast<std::size_t>(other)] == 0)) {
          edge_overlaps_.push_back({std::min(e, other), std::max(e, other)});
        }
      });
    }
  }
}

void FeatureTree::follow(std::span<const VertexId> strayed, const linear::VertexField& x, const linear::VertexField& v,
                         double since, double reach, std::span<const float> slack, double thickness,
                         std::vector<FeaturePair>& pairs) {
  vertex_overlaps_.clear();
  edge_overlaps_.clear();
  half_reach_ = static_cast<float>(0.5 * reach) + kRounding;
  for (const VertexId i : strayed) {
    motion_.slack[static_cast<std::size_t>(i)] = slack[static_cast<std::size_t>(i)];
    set_line(i, x.col(i) + since * v.col(i), v.col(i), since);
  }
  refit_around(strayed);
  for (const std::int32_t t : strayed_triangles_) extend_gradients(t, static_cast<float>(since), slack);
  std::replace(arounds_found_.begin(), arounds_found_.end(), Around::kFlat, Around::kUnknown);
  for (const StrayedGroup& group : groups_) follow_group(group);
  for (const VertexId of : strayed) is_strayed_[static_cast<std::size_t>(of)] = 0;
  for (const std::int32_t t : strayed_triangles_) is_strayed_triangle_[static_cast<std::size_t>(t)] = 0;
  for (const std::int32_t e : strayed_edges_) is_strayed_edge_[static_cast<std::size_t>(e)] = 0;
  keep_near(reach, thickness, pairs);
}

}  // namespace kerf::contact
