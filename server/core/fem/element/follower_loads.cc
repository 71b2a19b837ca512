#include "server/core/fem/element/follower_loads.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "server/base/elementary.h"
#include "server/core/linear/cross_matrix.h"

namespace kerf::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLeastArm = 0.05;  // -, of the arm at rest; see EdgeMoment

// Calls visit(pressure, block, lane) for every triangle under pressure.
template <typename Visit>
void for_pressed(std::span<const ElementBlock> blocks, const Loads& loads, const Visit& visit) {
  const std::size_t size = std::min(loads.pressure.size(), blocks.size() * kLanes);
  for (std::size_t slot = 0; slot < size; ++slot) {
    const ElementBlock& block = blocks[slot / kLanes];
    const std::size_t lane = slot % kLanes;
    if (loads.pressure[slot] != 0.0 && block.area[lane] > 0.0) visit(loads.pressure[slot], block, lane);
  }
}

// Returns twice the area times the normal, m^2.
Vector3d doubled_area(const ElementBlock& block, std::size_t lane, const linear::VertexField& x) {
  const Vector3d corner = x.col(block.vertex[0][lane]);
  const Vector3d first = x.col(block.vertex[1][lane]) - corner;
  const Vector3d second = x.col(block.vertex[2][lane]) - corner;
  return first.cross(second);
}

// Geometry of the sheet at the edge of a moment. t is the unit vector along the edge, and v = arm x t is perpendicular
// to arm and t. v is 0 if the arm is along the edge.
struct Slope {
  Vector3d arm = Vector3d::Zero();  // m, the slope across the edge times the height of the triangle, outward
  Vector3d edge = Vector3d::Zero();
  double length = 0.0;
  Vector3d t = Vector3d::Zero();
  Vector3d v = Vector3d::Zero();
  double squared = 0.0;  // m^2, |v|^2, or the square of the least arm if that is greater
  bool is_short = false;

  Slope(const EdgeMoment& moment, const linear::VertexField& x) {
    for (std::size_t a = 0; a < moment.vertex.size(); ++a) {
      if (moment.vertex[a] != mesh::kNone)
        arm += moment.weight[a] * (x.col(moment.vertex[a]) - x.col(moment.vertex[0]));
    }
    edge = x.col(moment.vertex[(moment.edge + 2) % 3]) - x.col(moment.vertex[(moment.edge + 1) % 3]);
    length = edge.norm();
    if (length > 0.0) t = edge / length;
    v = arm.cross(t);
    const double least = kLeastArm * moment.arm;
    is_short = v.squaredNorm() < least * least;
    squared = is_short ? least * least : v.squaredNorm();
  }
};

}  // namespace

bool has_follower_loads(const Loads& loads) {
  return std::any_of(loads.pressure.begin(), loads.pressure.end(), [](double each) { return each != 0.0; }) ||
         std::any_of(loads.edge_moments.begin(), loads.edge_moments.end(),
                     [](const EdgeMoment& each) { return each.moment != 0.0; });
}

void add_follower_forces(std::span<const ElementBlock> blocks, const Loads& loads, const linear::VertexField& x,
                         linear::VertexField& f) {
  for_pressed(blocks, loads, [&](double pressure, const ElementBlock& block, std::size_t lane) {
    const Vector3d third = (pressure / 6.0) * doubled_area(block, lane, x);
    for (std::size_t k = 0; k < 3; ++k) f.col(block.vertex[k][lane]) += third;
  });
  for (const EdgeMoment& moment : loads.edge_moments) {
    const Slope slope(moment, x);
    const Vector3d push = (moment.moment / slope.squared) * slope.v;
    for (std::size_t a = 0; a < moment.vertex.size(); ++a) {
      if (moment.vertex[a] != mesh::kNone) f.col(moment.vertex[a]) += moment.weight[a] * push;
    }
  }
}

Vector3d follower_resultant(std::span<const ElementBlock> blocks, const Loads& loads, const linear::VertexField& x) {
  Vector3d sum = Vector3d::Zero();
  for_pressed(blocks, loads, [&](double pressure, const ElementBlock& block, std::size_t lane) {
    sum += 0.5 * pressure * doubled_area(block, lane, x);
  });
  return sum;
}

double edge_moment_energy(const Loads& loads) {
  double sum = 0.0;
  for (const EdgeMoment& each : loads.edge_moments) sum += 0.5 * each.compliance * each.moment * each.moment;
  return sum;
}

double follower_work(std::span<const ElementBlock> blocks, const Loads& loads, const linear::VertexField& from,
                     const linear::VertexField& to) {
  double work = 0.0;
  // The force is quadratic along the path, so Simpson's rule is exact.
  for_pressed(blocks, loads, [&](double pressure, const ElementBlock& block, std::size_t lane) {
    std::array<Vector3d, 3> start;
    std::array<Vector3d, 3> way;
    for (std::size_t k = 0; k < 3; ++k) {
      start[k] = from.col(block.vertex[k][lane]);
      way[k] = to.col(block.vertex[k][lane]) - start[k];
    }
    const Vector3d e1 = start[1] - start[0];
    const Vector3d e2 = start[2] - start[0];
    const Vector3d d1 = way[1] - way[0];
    const Vector3d d2 = way[2] - way[0];
    const Vector3d mean = e1.cross(e2) + 0.5 * (e1.cross(d2) + d1.cross(e2)) + d1.cross(d2) / 3.0;
    work += (pressure / 6.0) * mean.dot(way[0] + way[1] + way[2]);
  });
  for (const EdgeMoment& moment : loads.edge_moments) {
    const Slope before(moment, from);
    const Slope after(moment, to);
    const Vector3d t = (before.t + after.t).stableNormalized();
    const Vector3d p = before.arm - before.arm.dot(t) * t;
    const Vector3d q = after.arm - after.arm.dot(t) * t;
    work -= moment.moment * arc_tangent(p.cross(q).dot(t), p.dot(q));
  }
  return work;
}

Matrix3d pressure_stiffness(double pressure, const std::array<Vector3d, 3>& corner, std::size_t i, std::size_t j,
                            MatrixPart part) {
  const Vector3d across_i = corner[(i + 2) % 3] - corner[(i + 1) % 3];
  const Vector3d across_j = corner[(j + 2) % 3] - corner[(j + 1) % 3];
  return linear::cross_matrix((pressure / 12.0) *
                              ((part == MatrixPart::kSymmetric ? 1.0 : -1.0) * across_i - across_j));
}

EdgeMomentTangent::EdgeMomentTangent(const EdgeMoment& moment, const linear::VertexField& x) : moment_(moment) {
  const Slope slope(moment, x);
  if (!(slope.length > 0.0)) return;
  // Derivative of the force m v / |v|^2 by v = arm x t.
  Matrix3d by_v = Matrix3d::Identity();
  if (!slope.is_short) by_v -= (2.0 / slope.squared) * slope.v * slope.v.transpose();
  by_v *= moment.moment / slope.squared;
  by_slope_ = -by_v * linear::cross_matrix(slope.t);
  by_edge_ =
      by_v * linear::cross_matrix(slope.arm) * (Matrix3d::Identity() - slope.t * slope.t.transpose()) / slope.length;
}

Matrix3d EdgeMomentTangent::derivative(std::size_t a, std::size_t b) const {
  Matrix3d result = moment_.weight[b] * by_slope_;
  if (b == (moment_.edge + 2) % 3) result += by_edge_;
  if (b == (moment_.edge + 1) % 3) result -= by_edge_;
  return moment_.weight[a] * result;
}

Matrix3d EdgeMomentTangent::stiffness(std::size_t a, std::size_t b, MatrixPart part) const {
  const double mirrored = part == MatrixPart::kSymmetric ? 1.0 : -1.0;
  return -0.5 * (derivative(a, b) + mirrored * derivative(b, a).transpose());
}

}  // namespace kerf::fem
