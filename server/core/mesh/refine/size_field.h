#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kerf::mesh {

// The edge length wanted near the segment from a to b, or near a point if both are equal. It is length + growth *
// (distance from the segment). All lengths of a field have the same unit, any.
struct SizeSource {
  Eigen::Vector2d a{0.0, 0.0};
  Eigen::Vector2d b{0.0, 0.0};
  double length = 0.0;  // > 0
  double growth = 0.0;  // -, >= 0
};

// A field of edge lengths: at each place the least of the lengths that the sources want, and at most `largest`. Along
// any path it changes by at most the largest growth per distance, so that neighbouring edges differ little. A query
// descends a tree of boxes around the sources, the branch with the lower bound first. It costs O(log n) if sources have
// similar lengths.
class SizeField {
 public:
  SizeField(double largest, std::vector<SizeSource> sources);

  [[nodiscard]] double at(const Eigen::Vector2d& position) const;
  [[nodiscard]] double largest() const { return largest_; }
  // Returns the largest growth of all sources; 0 if there are none.
  [[nodiscard]] double steepest_growth() const { return steepest_growth_; }

 private:
  struct Node {
    Eigen::AlignedBox2d box;
    double least_length = 0.0;
    double least_growth = 0.0;
    std::int32_t begin = 0, end = 0;  // range in sources_, the whole branch
    std::int32_t right = -1;          // index of the right child, -1 in a leaf; the left child is the next node
  };

  std::int32_t build(std::int32_t begin, std::int32_t end);
  void descend(std::int32_t node, const Eigen::Vector2d& position, double& least) const;

  double largest_;
  double steepest_growth_ = 0.0;
  std::vector<SizeSource> sources_;
  std::vector<Node> nodes_;
};

}  // namespace kerf::mesh
