#include "server/core/contact/feature_tree.h"

#include <algorithm>
#include <array>
#include <vector>

#include <Eigen/Geometry>

namespace kerf::contact {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

// Returns true if the inside of a rectangle and a segment have a point in common. May be wrong by rounding in favour of
// true.
bool meets(const Eigen::AlignedBox2d& rectangle, const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  const Eigen::Vector2d low = p.cwiseMin(q), high = p.cwiseMax(q);
  if (!(low.x() < rectangle.max().x() && high.x() > rectangle.min().x() && low.y() < rectangle.max().y() &&
        high.y() > rectangle.min().y())) {
    return false;
  }
  const Eigen::Vector2d normal(q.y() - p.y(), p.x() - q.x());
  const double at = normal.dot(rectangle.center() - p);
  const double extent = 0.5 * normal.cwiseAbs().dot(rectangle.sizes());
  return std::abs(at) < extent;
}

}  // namespace

FeatureTree::NodeBox FeatureTree::box_of(const BoxLanes& boxes, std::size_t place) {
  NodeBox box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.low[static_cast<Eigen::Index>(k)] = boxes.low[k][place];
    box.high[static_cast<Eigen::Index>(k)] = boxes.high[k][place];
  }
  return box;
}

void FeatureTree::set(const mesh::TriangleMesh& mesh) {
  std::vector<TriangleId> order;
  std::vector<Eigen::Vector2d> centroids(static_cast<std::size_t>(mesh.num_triangle_slots()));
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    order.push_back(t);
    const std::array<VertexId, 3>& v = mesh.vertices(t);
    centroids[static_cast<std::size_t>(t)] =
        (mesh.rest_position(v[0]) + mesh.rest_position(v[1]) + mesh.rest_position(v[2])) / 3.0;
  }
  // Pieces come one after the other, so that few nodes hold two.
  std::stable_sort(order.begin(), order.end(),
                   [&](TriangleId a, TriangleId b) { return mesh.piece(a) < mesh.piece(b); });
  nodes_.clear();
  if (!order.empty()) build_node(0, static_cast<std::int32_t>(order.size()), order, centroids);
  features_.set(mesh, order);
  find_others();
  motion_.resize(static_cast<std::size_t>(mesh.num_vertices()));
  by_id_.resize(static_cast<std::size_t>(mesh.num_vertices()));
  is_fitted_ = false;
  place_.assign(static_cast<std::size_t>(mesh.num_vertices()), 0);
  for (std::size_t k = 0; k < features_.vertices.size(); ++k) {
    place_[static_cast<std::size_t>(features_.vertices[k])] = static_cast<std::int32_t>(k);
  }
  is_strayed_.assign(static_cast<std::size_t>(mesh.num_vertices()), 0);
  is_strayed_edge_.assign(features_.edges.size(), 0);
  is_strayed_triangle_.assign(features_.triangles.size(), 0);
  leaf_of_.resize(features_.triangles.size());
  parent_.assign(nodes_.size(), -1);
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const auto index = static_cast<std::int32_t>(k);
    const Node& node = nodes_[k];
    if (node.right != 0) {
      parent_[k + 1] = parent_[static_cast<std::size_t>(node.right)] = index;
    } else {
      std::fill(leaf_of_.begin() + node.begin, leaf_of_.begin() + node.end, index);
    }
  }
  vertex_boxes_.resize(features_.vertices.size());
  triangle_boxes_.resize(features_.triangles.size());
  edge_boxes_.resize(features_.edges.size());
}

std::int32_t FeatureTree::build_node(std::int32_t begin, std::int32_t end, std::span<TriangleId> order,
                                     std::span<const Eigen::Vector2d> centroids) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  Node& node = nodes_.emplace_back();
  node.begin = begin;
  node.end = end;
  if (end - begin <= kLeaf) return index;
  const auto first = order.begin() + begin, last = order.begin() + end, middle = first + (end - begin) / 2;
  Eigen::AlignedBox2d extent;
  for (auto it = first; it != last; ++it) extent.extend(centroids[static_cast<std::size_t>(*it)]);
  const Eigen::Index axis = extent.sizes().x() >= extent.sizes().y() ? 0 : 1;
  std::nth_element(first, middle, last, [&](TriangleId a, TriangleId b) {
    const double at_a = centroids[static_cast<std::size_t>(a)][axis],
                 at_b = centroids[static_cast<std::size_t>(b)][axis];
    return at_a != at_b ? at_a < at_b : a < b;
  });
  build_node(begin, begin + (end - begin) / 2, order, centroids);
  const std::int32_t right = build_node(begin + (end - begin) / 2, end, order, centroids);
  nodes_[static_cast<std::size_t>(index)].right = right;
  return index;
}

// Finds, for each node, the triangles outside of it that meet its rectangle, and if a border or lip does.
void FeatureTree::find_others() {
  others_.clear();
  std::vector<Eigen::AlignedBox2d> extents(features_.triangles.size());
  for (std::size_t t = 0; t < extents.size(); ++t) {
    for (const VertexId v : features_.triangles[t].vertices)
      extents[t].extend(features_.material[static_cast<std::size_t>(v)]);
  }
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Node& node = nodes_[k];
    node.rectangle.setEmpty();
    if (node.right != 0) {
      node.rectangle.extend(nodes_[k + 1].rectangle);
      node.rectangle.extend(nodes_[static_cast<std::size_t>(node.right)].rectangle);
    } else {
      for (std::int32_t t = node.begin; t < node.end; ++t) node.rectangle.extend(extents[static_cast<std::size_t>(t)]);
    }
  }
  std::vector<std::int32_t> stack;
  for (Node& node : nodes_) {
    node.first_other = static_cast<std::int32_t>(others_.size());
    stack.assign(1, 0);
    while (!stack.empty()) {
      const std::int32_t at = stack.back();
      stack.pop_back();
      const Node& other = nodes_[static_cast<std::size_t>(at)];
      if (other.begin >= node.begin && other.end <= node.end) continue;
      if (!node.rectangle.intersects(other.rectangle)) continue;
      if (other.right != 0) {
        stack.push_back(other.right);
        stack.push_back(at + 1);
        continue;
      }
      for (std::int32_t t = other.begin; t < other.end; ++t) {
        if ((t < node.begin || t >= node.end) && node.rectangle.intersects(extents[static_cast<std::size_t>(t)])) {
          others_.push_back(t);
        }
      }
    }
    node.end_other = static_cast<std::int32_t>(others_.size());
    node.is_whole = true;
  }
  for (const auto& [p, q] : features_.borders) {
    const Eigen::Vector2d& from = features_.material[static_cast<std::size_t>(p)];
    const Eigen::Vector2d& to = features_.material[static_cast<std::size_t>(q)];
    stack.assign(1, 0);
    while (!stack.empty()) {
      const std::int32_t at = stack.back();
      stack.pop_back();
      Node& node = nodes_[static_cast<std::size_t>(at)];
      if (!meets(node.rectangle, from, to)) continue;
      node.is_whole = false;
      if (node.right == 0) continue;
      stack.push_back(at + 1);
      stack.push_back(node.right);
    }
  }
}

}  // namespace kerf::contact
