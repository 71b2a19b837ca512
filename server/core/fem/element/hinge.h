#pragma once

#include <array>

#include <Eigen/Core>

namespace kerf::fem {

// What a hinge is at rest, which decides from where on a triangle counts as collapsed.
struct HingeSize {
  double length = 0.0;             // m, of the edge
  std::array<double, 2> height{};  // m, of both triangles over it
};

// Two triangles that share an edge: the angle theta from one plane to the other, in (-pi, pi], positive where they fold
// towards the side that their normals are on. Its gradient and second derivative: Tamstorf and Grinspun 2013, "Discrete
// bending forces and their Jacobians", section 3, put together here from how each triangle turns about the edge.
// Where a triangle has collapsed to less than kLeastArea of its area (rest_bending.h), or the edge to less than that of
// its length, the gradient is the true one times the square of what is left of that, so that all numbers stay finite
// and forces keep their balance, without a resultant or a torque; the second derivative counts those factors in part.
// The angle is the true one, 0 where a triangle has no plane at all. At pi, of a sheet that is folded onto itself, it
// jumps.
class Hinge {
 public:
  // x: both ends of the edge, then the corner on its left and that on its right, m.
  Hinge(const std::array<Eigen::Vector3d, 4>& x, const HingeSize& rest);

  [[nodiscard]] double theta() const { return theta_; }  // rad
  // 1/m, by the four points.
  [[nodiscard]] std::array<Eigen::Vector3d, 4> gradient() const;
  // 1/m^2; rows and columns 3 i + c of point i, coordinate c. Symmetric.
  [[nodiscard]] Eigen::Matrix<double, 12, 12> hessian() const;

 private:
  // One of the triangles, turning about the edge: theta changes by rate . sum_k weight_k dx_k, k over both ends of the
  // edge and the corner.
  struct Wing {
    Eigen::Vector3d corner = Eigen::Vector3d::Zero();  // m, from the beginning of the edge
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // m^2; twice the area
    Eigen::Vector3d unit = Eigen::Vector3d::Zero();    // -
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();    // 1/m
    std::array<double, 3> weight{};                    // -, of sum 0
    double over_squared = 0.0;                         // 1/m^4; of the normal
    double own_share = 1.0;                            // -, below 1 where it has collapsed, and
    double share = 1.0;                                // that of the other wing
    bool has_collapsed = false;
  };
  [[nodiscard]] Wing make_wing(const Eigen::Vector3d& corner, double sign, double least) const;
  void add_second_derivatives(const Wing& wing, double sign, std::size_t corner,
                              Eigen::Matrix<double, 12, 12>& sum) const;

  Eigen::Vector3d edge_;  // m
  double length_ = 0.0;   // m, of the edge
  double squared_ = 0.0;  // m^2, of the edge, or the least that counts
  double share_ = 1.0;    // -, below 1 where the edge has collapsed
  bool is_short_ = false;
  std::array<Wing, 2> wings_;
  double theta_ = 0.0;
};

}  // namespace kerf::fem
