#include "server/core/contact/feature_tree.h"

#include <algorithm>
#include <array>
#include <vector>

#include <Eigen/Geometry>

namespace kerf::contact {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

constexpr double kStray = 2.4;  // -, how often the slack of its corners an altitude of a triangle may lose

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

FeatureTree::NodeBox FeatureTree::box_of(const BoxLanes& boxes, std::int32_t place) {
  NodeBox box;
  const auto at = static_cast<std::size_t>(place);
  for (std::size_t k = 0; k < 3; ++k) {
    box.low[static_cast<Eigen::Index>(k)] = boxes.low[k][at];
    box.high[static_cast<Eigen::Index>(k)] = boxes.high[k][at];
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
  list_leaf_vertices();
  set_rectangles();
  shapes_.clear();
  for (const SheetFeatures::Triangle& triangle : features_.triangles) {
    const Eigen::Matrix2f inverse = triangle.inverse_edges.cast<float>();
    shapes_.push_back({triangle.vertices,
                       {inverse(0, 0), inverse(1, 0), inverse(0, 1), inverse(1, 1)},
                       static_cast<float>(kStray / triangle.altitude)});
  }
  lines_.resize(static_cast<std::size_t>(mesh.num_vertices()));
  gradients_.resize(nodes_.size());
  arounds_found_.resize(nodes_.size());
  is_leaf_fitted_.resize(nodes_.size());
  motion_.resize(static_cast<std::size_t>(mesh.num_vertices()));
  since_.resize(static_cast<std::size_t>(mesh.num_vertices()));
  is_fitted_ = false;
  place_.assign(static_cast<std::size_t>(mesh.num_vertices()), 0);
  for (std::size_t k = 0; k < features_.vertices.size(); ++k) {
    place_[static_cast<std::size_t>(features_.vertices[k])] = static_cast<std::int32_t>(k);
  }
  is_strayed_.assign(static_cast<std::size_t>(mesh.num_vertices()), 0);
  is_strayed_edge_.assign(features_.edges.size(), 0);
  is_strayed_triangle_.assign(features_.triangles.size(), 0);
  leaf_of_.resize(features_.triangles.size());
  leaf_of_vertex_.resize(features_.vertices.size());
  leaf_of_edge_.resize(features_.edges.size());
  parent_.assign(nodes_.size(), -1);
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const auto index = static_cast<std::int32_t>(k);
    const Node& node = nodes_[k];
    if (node.right != 0) {
      parent_[k + 1] = parent_[static_cast<std::size_t>(node.right)] = index;
    } else {
      const BoxRange vertices = vertices_of(node), edges = edges_of(node);
      std::fill(leaf_of_.begin() + node.begin, leaf_of_.begin() + node.end, index);
      std::fill(leaf_of_vertex_.begin() + vertices.begin, leaf_of_vertex_.begin() + vertices.end, index);
      std::fill(leaf_of_edge_.begin() + edges.begin, leaf_of_edge_.begin() + edges.end, index);
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

void FeatureTree::list_leaf_vertices() {
  leaf_vertices_.clear();
  for (Node& node : nodes_) {
    if (node.right != 0) continue;
    node.first_vertex = static_cast<std::int32_t>(leaf_vertices_.size());
    for (std::int32_t t = node.begin; t < node.end; ++t) {
      const auto& corners = features_.triangles[static_cast<std::size_t>(t)].vertices;
      leaf_vertices_.insert(leaf_vertices_.end(), corners.begin(), corners.end());
    }
    const auto first = leaf_vertices_.begin() + node.first_vertex;
    std::sort(first, leaf_vertices_.end());
    leaf_vertices_.erase(std::unique(first, leaf_vertices_.end()), leaf_vertices_.end());
    node.end_vertex = static_cast<std::int32_t>(leaf_vertices_.size());
  }
}

void FeatureTree::set_rectangles() {
  constexpr double kGrowth = 1.25;  // -, of the larger side of a node
  covers_.clear();
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    Node& node = nodes_[k];
    node.rectangle.setEmpty();
    if (node.right != 0) {
      node.rectangle.extend(nodes_[k + 1].rectangle);
      node.rectangle.extend(nodes_[static_cast<std::size_t>(node.right)].rectangle);
      continue;
    }
    for (std::int32_t i = node.first_vertex; i < node.end_vertex; ++i) {
      node.rectangle.extend(features_.material[static_cast<std::size_t>(leaf_vertices_[static_cast<std::size_t>(i)])]);
    }
  }
  for (Node& node : nodes_) {
    const double by = kGrowth * node.rectangle.sizes().maxCoeff();
    const Eigen::Vector2d margin(by, by);
    node.around = Eigen::AlignedBox2d(node.rectangle.min() - margin, node.rectangle.max() + margin)
                      .intersection(nodes_[0].rectangle);
  }
}

bool FeatureTree::has_border_inside(const Eigen::AlignedBox2d& rectangle) {
  bool is_found = false;
  visit_down(nodes_, cover_stack_, [&](std::int32_t at) {
    const Node& node = nodes_[static_cast<std::size_t>(at)];
    if (is_found || !rectangle.intersects(node.rectangle)) return false;
    if (node.right != 0) return true;
    // A border lies in the rectangle of the leaf that has its triangle.
    const auto begin = features_.borders.begin() + features_.first_border[static_cast<std::size_t>(node.begin)];
    const auto end = features_.borders.begin() + features_.first_border[static_cast<std::size_t>(node.end)];
    is_found = std::any_of(begin, end, [&](const std::array<VertexId, 2>& ends) {
      return meets(rectangle, features_.material[static_cast<std::size_t>(ends[0])],
                   features_.material[static_cast<std::size_t>(ends[1])]);
    });
    return false;
  });
  return is_found;
}

std::span<const std::int32_t> FeatureTree::find_cover(const Eigen::AlignedBox2d& rectangle, std::int32_t without,
                                                      Cover& cover) {
  if (cover.kind == Cover::Kind::kUnknown) {
    cover.kind = has_border_inside(rectangle) ? Cover::Kind::kBroken : Cover::Kind::kWhole;
    cover.first = static_cast<std::int32_t>(covers_.size());
    if (cover.kind == Cover::Kind::kWhole) {
      visit_down(nodes_, cover_stack_, [&](std::int32_t at) {
        const Node& node = nodes_[static_cast<std::size_t>(at)];
        if (at == without || !rectangle.intersects(node.rectangle)) return false;
        if (node.right != 0 && !rectangle.contains(node.rectangle)) return true;
        covers_.push_back(at);
        return false;
      });
    }
    cover.end = static_cast<std::int32_t>(covers_.size());
  }
  return std::span<const std::int32_t>(covers_).subspan(static_cast<std::size_t>(cover.first),
                                                        static_cast<std::size_t>(cover.end - cover.first));
}

}  // namespace kerf::contact
