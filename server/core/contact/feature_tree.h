#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/feature_pair.h"
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
// itself while it is nearly flat: let F be the deformation gradient, and |F - F0| <= rho in the whole rectangle. Then
// |x(A) - x(B)| >= (sigma_min(F0) - rho) |A - B| for any two of its points, as x(B) - x(A) is the integral of F (B -
// A). Both ends of the motion are looked at; a ball of F is convex, so all that lies between is inside.
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

  // Returns true if find_pairs() has looked at the parts of the sheet, so that follow() may be called.
  [[nodiscard]] bool is_fitted() const { return is_fitted_; }
  // Gives some vertices other lines, after find_pairs(): x + t v (m, m/s) from t = `since` (s) of its motion on. Fills
  // `pairs`, ordered by kind, with all pairs that include such a vertex and may come near.
  void follow(std::span<const mesh::VertexId> strayed, const linear::VertexField& x, const linear::VertexField& v,
              double since, double reach, std::span<const float> slack, double thickness,
              std::vector<FeaturePair>& pairs);

 private:
  static constexpr std::int32_t kLeaf = 8;  // most triangles of a leaf

  // A box relative to the middle of the sheet, m; the fourth entries are not used.
  struct NodeBox {
    Eigen::Array4f low = Eigen::Array4f::Constant(-1.0F), high = Eigen::Array4f::Constant(1.0F);

    [[nodiscard]] bool overlaps(const NodeBox& other) const {
      return (low < other.high).all() && (other.low < high).all();
    }
  };
  // A node holds triangles [begin, end) of features_; of other nodes than leaves the left child is the next one.
  struct Node {
    NodeBox box;  // of the motion
    std::int32_t begin = 0, end = 0;
    std::int32_t right = 0;                       // 0: a leaf
    std::int32_t first_other = 0, end_other = 0;  // in others_: triangles of other nodes that meet its rectangle
    bool is_whole = false;                        // its rectangle has no border or lip inside
    Eigen::AlignedBox2d rectangle;                // material, m
  };
  struct Query {
    const StraightMotion& motion;
    std::span<const float> slack;  // m
    double reach = 0.0;            // m
  };

  std::int32_t build_node(std::int32_t begin, std::int32_t end, std::span<mesh::TriangleId> order,
                          std::span<const Eigen::Vector2d> centroids);
  void find_others();
  void refit(const Query& query);
  // Sets the line of a vertex, which is at x (m) after `since` (s) of the motion, and its box from then on.
  void set_line(mesh::VertexId v, const Eigen::Vector3d& x, const Eigen::Vector3d& velocity, double since,
                float margin);
  // Lists the features at strayed vertices, and makes their boxes and those of nodes around them follow.
  void refit_around(std::span<const mesh::VertexId> strayed);
  // Calls visit(leaf) for each leaf whose box overlaps `box`.
  template <typename Visit>
  void for_each_leaf(const NodeBox& box, const Visit& visit);
  [[nodiscard]] bool is_flat(const Node& node, const Query& query) const;
  void search_within(std::int32_t index, const Query& query);
  void search_between(std::int32_t first, std::int32_t second);
  void search_leaves(const Node& a, const Node& b);
  // Appends those pairs of `candidates` that may come near to `pairs`.
  void keep_near(FeaturePair::Kind kind, const PairLanes& candidates, double reach, double thickness,
                 std::vector<FeaturePair>& pairs);
  static NodeBox box_of(const BoxLanes& boxes, std::size_t place);
  [[nodiscard]] BoxRange vertices_of(const Node& node) const;
  [[nodiscard]] BoxRange edges_of(const Node& node) const;
  void add_vertex_candidate(mesh::VertexId v, std::int32_t triangle);
  void add_edge_candidate(std::int32_t first, std::int32_t second);
  // Returns true if a pair may come nearer than `reach` (m) in the motion.
  [[nodiscard]] bool comes_near(const FeaturePair& pair, double reach) const;
  // Returns half the distance at rest of a pair, m, or `most` if that is less.
  [[nodiscard]] double half_distance_at_rest(const FeaturePair& pair, double most) const;

  SheetFeatures features_;
  std::vector<Node> nodes_;
  std::vector<std::int32_t> others_;
  bool is_fitted_ = false;
  double duration_ = 0.0;                                         // s, of the motion
  Eigen::Vector3d middle_{0.0, 0.0, 0.0}, drift_{0.0, 0.0, 0.0};  // m, m/s, of the frame of the boxes
  std::vector<std::int32_t> leaf_of_, parent_;                    // by triangle; by node
  std::vector<std::int32_t> place_;                               // by vertex id: its place in `vertices`
  std::vector<std::uint8_t> is_strayed_;                          // by vertex id
  std::vector<std::int32_t> strayed_triangles_, strayed_edges_, stack_;
  std::vector<std::uint8_t> is_strayed_edge_, is_strayed_triangle_;
  MotionLanes motion_;
  BoxLanes by_id_;                                       // of the motion, by vertex id
  BoxLanes vertex_boxes_, triangle_boxes_, edge_boxes_;  // of the motion; by place in `vertices`, triangle, edge
  PairLanes vertex_candidates_, edge_candidates_;
  std::vector<std::array<std::int32_t, 2>> overlaps_;
  std::vector<std::int32_t> near_;
};

}  // namespace kerf::contact
