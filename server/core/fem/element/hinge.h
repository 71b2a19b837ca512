#pragma once

#include <array>

#include <Eigen/Core>

namespace kerf::fem {

// Size of a hinge at rest. It defines below which size a triangle or the edge counts as collapsed.
struct HingeSize {
  double length = 0.0;             // m, of the edge
  std::array<double, 2> height{};  // m, of each triangle above the edge
};

// Two triangles that share an edge. theta is the angle from one plane to the other, in (-pi, pi], positive if they fold
// towards the side of their normals. For its gradient and second derivative see Tamstorf and Grinspun 2013, "Discrete
// bending forces and their Jacobians", section 3. Here they are assembled from the rotation of each triangle about the
// edge.
// A triangle counts as collapsed below kLeastArea of its rest area (rest_bending.h), an edge below that fraction of its
// rest length. The gradient is then the true one times the square of the size over this limit. All numbers stay finite,
// and forces keep their balance, without resultant or torque. The second derivative includes these factors only in
// part. The angle is the true one, or 0 if a triangle has no plane at all. At pi, where a sheet is folded onto itself,
// it jumps.
class Hinge {
 public:
  // x, m: both ends of the edge, the corner to its left, the corner to its right.
  Hinge(const std::array<Eigen::Vector3d, 4>& x, const HingeSize& rest);

  [[nodiscard]] double theta() const { return theta_; }  // rad
  // Gradient of theta by the four points, 1/m.
  [[nodiscard]] std::array<Eigen::Vector3d, 4> gradient() const;
  // Second derivatives of theta, 1/m^2. Rows and columns are 3 i + c for coordinate c of point i. Symmetric.
  [[nodiscard]] Eigen::Matrix<double, 12, 12> hessian() const;

 private:
  // One of the triangles, rotating about the edge: theta changes by rate . sum_k weight_k dx_k, with k over both ends
  // of the edge and the corner.
  struct Wing {
    Eigen::Vector3d corner = Eigen::Vector3d::Zero();  // m, relative to the beginning of the edge
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // m^2; its length is twice the area
    Eigen::Vector3d unit = Eigen::Vector3d::Zero();    // -
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();    // 1/m
    std::array<double, 3> weight{};                    // -, sums to 0
    double over_squared = 0.0;                         // 1/m^4; reciprocal square of the normal
    double own_share = 1.0;                            // -, factor of the gradient for this triangle; below 1 if it has
                                                       // collapsed
    double share = 1.0;                                // own_share of the other wing
    bool has_collapsed = false;
  };
  [[nodiscard]] Wing make_wing(const Eigen::Vector3d& corner, double sign, double least) const;
  void add_second_derivatives(const Wing& wing, double sign, std::size_t corner,
                              Eigen::Matrix<double, 12, 12>& sum) const;

  Eigen::Vector3d edge_;  // m
  double length_ = 0.0;   // m, of the edge
  double squared_ = 0.0;  // m^2, square of length_, or of the least length if that is greater
  double share_ = 1.0;    // -, factor of the gradient for the edge; below 1 if it has collapsed
  bool is_short_ = false;
  std::array<Wing, 2> wings_;
  double theta_ = 0.0;
};

}  // namespace kerf::fem
