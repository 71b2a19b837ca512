#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kerf::mesh {

// Edge length wanted near the segment from a to b (a point if both are equal): length on it, and length + growth *
// distance away from it. Any unit of length, the same for all.
struct SizeSource {
  Eigen::Vector2d a{0.0, 0.0};
  Eigen::Vector2d b{0.0, 0.0};
  double length = 0.0;  // > 0
  double growth = 0.0;  // -, >= 0
};

// Local edge lengths: at each place the least of those wanted by the sources, and at most `largest`. With all growths
// up to g it is Lipschitz with constant g, so that neighbouring edges differ little. A query descends a tree of boxes
// around the sources, best-bounded branches first: O(log n) where sources are of similar length.
class SizeField {
 public:
  SizeField(double largest, std::vector<SizeSource> sources);

  [[nodiscard]] double at(const Eigen::Vector2d& position) const;
  [[nodiscard]] double largest() const { return largest_; }
  // Largest growth of all sources; 0 without any.
  [[nodiscard]] double steepest_growth() const { return steepest_growth_; }

 private:
  struct Node {
    Eigen::AlignedBox2d box;
    double least_length = 0.0;
    double least_growth = 0.0;
    std::int32_t begin = 0, end = 0;  // of sources_; the whole branch
    std::int32_t right = -1;          // the left child is the next node; -1: a leaf
  };

  std::int32_t build(std::int32_t begin, std::int32_t end);
  void descend(std::int32_t node, const Eigen::Vector2d& position, double& least) const;

  double largest_;
  double steepest_growth_ = 0.0;
  std::vector<SizeSource> sources_;
  std::vector<Node> nodes_;
};

}  // namespace kerf::mesh
