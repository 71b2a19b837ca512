#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/feature_pair.h"
#include "server/core/contact/gradient_box.h"
#include "server/core/contact/pair_lanes.h"
#include "server/core/contact/sheet_features.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::contact {

// A motion of all vertices along straight lines, from `x` (3 x V, m) with constant velocities `v` (m/s) for `duration`
// (s).
struct StraightMotion {
  const linear::VertexField& x;
  const linear::VertexField& v;
  double duration = 0.0;
};

// Finds the pairs of features of a sheet that can come near each other during a motion.
//
// The tree halves the sheet in material space. A part whose bounding rectangle has no border or lip inside cannot touch
// itself while it is nearly flat, see GradientBox. Two parts next to each other cannot either while a rectangle around
// both is flat. Boxes of features are made only for the leaves that are left.
class FeatureTree {
 public:
  // Sets up the features of another topology. The result depends on the mesh alone.
  void set(const mesh::TriangleMesh& mesh);
  [[nodiscard]] const SheetFeatures& features() const { return features_; }

  // Fills `pairs` with all pairs that may come nearer than `reach` (m) if each vertex stays within its slack (m, by
  // vertex id) of `motion`. Their thickness is half the distance at rest, at most `thickness` (m) and at least
  // twice what the check keeps. Ordered by kind
  // and by the tree.
  void find_pairs(const StraightMotion& motion, double reach, std::span<const float> slack, double thickness,
                  std::vector<FeaturePair>& pairs);
  // Returns true if there are no such pairs because parts of the sheet are flat or far apart. Takes little time, and
  // far less than find_pairs() where it is false. Pairs of features are not looked at.
  bool is_apart(const StraightMotion& motion, double reach, std::span<const float> slack);

  // Sets is_apart to 1 for each vertex at positions x (m) to which no other part of the sheet is nearer than `reach`
  // (m). Parts that were within twice that distance at rest are near at half of their distance then. Vertices on
  // borders and lips are not apart.
  void find_apart(const linear::VertexField& x, double reach, std::vector<std::uint8_t>& is_apart);

  // Returns true if find_pairs() or is_apart() has looked at the parts of the sheet, so that follow() may be called.
  [[nodiscard]] bool is_fitted() const { return is_fitted_; }
  // Gives some vertices other lines after that: x + t v (m, m/s) from t = `since` (s) of its motion on. Fills
  // `pairs`, ordered by kind, with all pairs that include such a vertex and may come near.
  void follow(std::span<const mesh::VertexId> strayed, const linear::VertexField& x, const linear::VertexField& v,
              double since, double reach, std::span<const float> slack, double thickness,
              std::vector<FeaturePair>& pairs);

 private:
  static constexpr std::int32_t kLeaf = 8;   // most triangles of a leaf
  static constexpr float kRounding = 2e-6F;  // m, of coordinates in floats

  // A box relative to the middle of the sheet, m; the fourth entries are not used.
  struct NodeBox {
    Eigen::Array4f low = Eigen::Array4f::Constant(-1.0F), high = Eigen::Array4f::Constant(1.0F);

    [[nodiscard]] bool overlaps(const NodeBox& other) const {
      return (low < other.high).all() && (other.low < high).all();
    }
    [[nodiscard]] NodeBox united(const NodeBox& other) const { return {low.min(other.low), high.max(other.high)}; }
    [[nodiscard]] NodeBox swept(const Eigen::Array4f& way) const { return {low + way.min(0.0F), high + way.max(0.0F)}; }
  };
  // Nodes that meet a rectangle in the material plane, found when they are first asked for.
  struct Cover {
    enum class Kind : std::uint8_t { kUnknown, kWhole, kBroken };
    Kind kind = Kind::kUnknown;       // whole: the rectangle has no border or lip inside
    std::int32_t first = 0, end = 0;  // in covers_, if it is whole
  };
  // A node holds triangles [begin, end) of features_; of other nodes than leaves the left child is the next one.
  struct Node {
    NodeBox box;                                // of the motion, in a frame that moves with `v`
    Eigen::Array4f v = Eigen::Array4f::Zero();  // m/s, mean of its vertices
    std::int32_t begin = 0, end = 0;
    std::int32_t right = 0;                         // 0: a leaf
    Eigen::AlignedBox2d rectangle;                  // material, m
    Cover others;                                   // leaves of other nodes that meet its rectangle
    Eigen::AlignedBox2d around;                     // material, m; a larger rectangle, within that of its parent
    Cover all;                                      // nodes that meet `around`
    std::int32_t first_vertex = 0, end_vertex = 0;  // of a leaf, in leaf_vertices_: corners of its triangles
  };
  // A strayed vertex, and the ends of its features in strayed_triangles_ and strayed_edges_.
  struct StrayedGroup {
    mesh::VertexId vertex = mesh::kNone;
    BoxRange triangles, edges;
  };
  struct Query {
    const StraightMotion& motion;
    std::span<const float> slack;  // m
    double reach = 0.0;            // m
  };

  std::int32_t build_node(std::int32_t begin, std::int32_t end, std::span<mesh::TriangleId> order,
                          std::span<const Eigen::Vector2d> centroids);
  void list_leaf_vertices();
  void set_rectangles();
  // Returns the nodes in `cover`, which is found if it is unknown: leaves that meet the rectangle, but none below node
  // `without`. A node that lies in the rectangle stands for its leaves.
  std::span<const std::int32_t> find_cover(const Eigen::AlignedBox2d& rectangle, std::int32_t without, Cover& cover);
  [[nodiscard]] bool has_border_inside(const Eigen::AlignedBox2d& rectangle);
  // Calls visit(node) from the root down for each node where it returns true for its parent. `stack` is scratch.
  template <typename Visit>
  static void visit_down(const std::vector<Node>& nodes, std::vector<std::int32_t>& stack, const Visit& visit);
  // Sets the lines of all vertices, in the frame of the sheet, and what gradients follow from them.
  void set_lines(const Query& query);
  // Adds the gradients of a triangle from `since` (s) to the end of the motion to `box`.
  void add_gradient(std::int32_t t, float since, std::span<const float> slack, GradientBox& box) const;
  // Sets the boxes of vertices and nodes.
  void refit(const Query& query);
  // Sets the boxes of the features of a leaf unless they are set.
  void fit_leaf(std::int32_t index);
  // Sets the line of a vertex, which is at x (m) after `since` (s) of the motion.
  void set_line(mesh::VertexId v, const Eigen::Vector3d& x, const Eigen::Vector3d& velocity, double since);
  // Sets motion_ of a vertex to its line.
  void set_motion(mesh::VertexId v);
  // Returns the box around vertices on their lines, in a frame that moves with a velocity (m/s).
  [[nodiscard]] NodeBox box_around(std::span<const mesh::VertexId> vertices, const Eigen::Array4f& frame) const;
  // Sets box `to` to that around some vertices, in the frame of a leaf.
  void set_box(std::span<const mesh::VertexId> vertices, const Node& leaf, BoxLanes& boxes, std::size_t to) const;
  // Returns the way (m) that the frame of node `of` moves in the frame of node `in`.
  [[nodiscard]] Eigen::Array4f way_between(const Node& of, const Node& in) const;
  // Lists the features at strayed vertices, each with one of them. Makes their boxes and those of nodes follow.
  void refit_around(std::span<const mesh::VertexId> strayed);
  // Sets the boxes of a feature and of the nodes around it.
  void refit_nodes(std::int32_t leaf, NodeBox box);
  // Makes the gradients of nodes include those of a strayed triangle.
  void extend_gradients(std::int32_t t, float since, std::span<const float> slack);
  // Returns true if the features listed with a strayed vertex lie in the rectangle around leaf `home`.
  [[nodiscard]] bool is_within_around(const StrayedGroup& group, const Node& home) const;
  // Sets leaves_ to those whose boxes overlap `box`, which is in the frame of leaf `home`, with their features set.
  // Those that are flat around it are left out if `may_skip`.
  void find_leaves(const NodeBox& box, std::int32_t home, bool may_skip);
  // Adds the pairs of a strayed vertex and of the features listed with it.
  void follow_group(const StrayedGroup& group);
  [[nodiscard]] const Node& leaf_at(const std::vector<std::int32_t>& leaves, std::int32_t place) const {
    return nodes_[static_cast<std::size_t>(leaves[static_cast<std::size_t>(place)])];
  }
  [[nodiscard]] bool is_flat(std::int32_t index);
  // Returns true if the rectangle around node `first` is flat and has node `second` inside.
  bool is_flat_around(std::int32_t first, std::int32_t second);
  // Sets leaf_pairs_ to those that may come near each other, or `most` of them.
  void find_leaf_pairs(const Query& query, std::size_t most);
  // Finds the features whose boxes overlap.
  void find_overlapping(const Query& query);
  void search_within(std::int32_t index, std::size_t most);
  void search_between(std::int32_t first, std::int32_t second, std::size_t most);
  void search_leaves(std::int32_t first, std::int32_t second);
  // Appends those pairs of `candidates` that may come near to `pairs`.
  // Sets `pairs` to the candidates that may come near.
  void keep_near(double reach, double thickness, std::vector<FeaturePair>& pairs);
  // Sets candidates_ to the features in vertex_overlaps_, or edge_overlaps_.
  void list_vertex_candidates();
  void list_edge_candidates();
  // Calls use(pair) for the candidates that may come near, if wants(pair), whose vertices are set.
  template <typename Wants, typename Use>
  void for_near(double reach, double thickness, const Wants& wants, const Use& use);
  template <typename Wants, typename Use>
  void for_near(FeaturePair::Kind kind, double reach, double thickness, const Wants& wants, const Use& use);
  static NodeBox box_of(const BoxLanes& boxes, std::int32_t place);
  [[nodiscard]] BoxRange vertices_of(const Node& node) const;
  [[nodiscard]] BoxRange edges_of(const Node& node) const;
  // Returns true if a pair may come nearer than `reach` (m) in the motion.
  [[nodiscard]] bool comes_near(const FeaturePair& pair, double reach) const;
  // Returns half the distance at rest of a pair, m, or `most` if that is less.
  [[nodiscard]] double half_distance_at_rest(const FeaturePair& pair, double most) const;

  SheetFeatures features_;
  std::vector<Node> nodes_;
  std::vector<std::int32_t> covers_, cover_stack_;
  std::vector<mesh::VertexId> leaf_vertices_;
  std::vector<TriangleShape> shapes_;   // by triangle
  std::vector<VertexLine> lines_;       // by vertex id, when find_pairs() was called
  std::vector<GradientBox> gradients_;  // by node
  enum class Around : std::uint8_t { kUnknown, kFlat, kBent };
  std::vector<Around> arounds_found_;         // by node
  std::vector<std::uint8_t> is_leaf_fitted_;  // by node
  bool is_fitted_ = false;
  double duration_ = 0.0;                                         // s, of the motion
  Eigen::Vector3d middle_{0.0, 0.0, 0.0}, drift_{0.0, 0.0, 0.0};  // m, m/s, of the frame of the boxes
  std::vector<std::int32_t> leaf_of_, parent_;                    // by triangle; by node
  std::vector<std::int32_t> leaf_of_vertex_, leaf_of_edge_;       // by place in `vertices`; by edge
  std::vector<float> since_;                                      // s, by vertex id: from when on its line is its own
  float half_reach_ = 0.0F;                                       // m
  std::vector<std::int32_t> place_;                               // by vertex id: its place in `vertices`
  std::vector<std::uint8_t> is_strayed_;                          // by vertex id
  std::vector<std::int32_t> strayed_triangles_, strayed_edges_, stack_, leaves_;
  std::vector<StrayedGroup> groups_;
  std::vector<NodeBox> group_boxes_;  // scratch: of the features listed with a vertex, in the frame of its leaf
  std::vector<std::uint8_t> is_strayed_edge_, is_strayed_triangle_;
  MotionLanes motion_;
  // Boxes of the motion, in the frames of their leaves; by place in `vertices`, triangle, edge.
  BoxLanes vertex_boxes_, triangle_boxes_, edge_boxes_;
  std::vector<std::array<std::int32_t, 2>> leaf_pairs_;
  // Features whose boxes overlap: the place of a vertex in `vertices` and a triangle, or two edges.
  std::vector<std::array<std::int32_t, 2>> vertex_overlaps_, edge_overlaps_;
  std::vector<std::array<std::int32_t, 2>> overlaps_;  // scratch
  PairLanes candidates_;                               // scratch
  std::vector<std::int32_t> near_;
  std::vector<float> near_speeds_;  // m/s, by place in near_
};

template <typename Visit>
void FeatureTree::visit_down(const std::vector<Node>& nodes, std::vector<std::int32_t>& stack, const Visit& visit) {
  stack.assign(1, 0);
  while (!stack.empty()) {
    const std::int32_t at = stack.back();
    stack.pop_back();
    if (!visit(at) || nodes[static_cast<std::size_t>(at)].right == 0) continue;
    stack.push_back(nodes[static_cast<std::size_t>(at)].right);
    stack.push_back(at + 1);
  }
}

}  // namespace kerf::contact
