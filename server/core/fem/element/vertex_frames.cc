#include "server/core/fem/element/vertex_frames.h"

#include <cstddef>

#include <Eigen/Geometry>

#include "server/core/fem/element/element_lanes.h"

namespace kerf::fem {
namespace {

// Returns an orthonormal frame from the sums of first tangents, second tangents and normals.
Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& sums) {
  const Eigen::Vector3d normal = sums.col(2).stableNormalized();
  // The sums of both tangents determine the first axis of the frame.
  const Eigen::Vector3d along = sums.col(0) + sums.col(1).cross(normal);
  const Eigen::Vector3d tangent = (along - along.dot(normal) * normal).stableNormalized();
  Eigen::Matrix3d frame;
  frame << tangent, normal.cross(tangent), normal;
  constexpr double kOrthonormal = 1e-6;
  const double defect = (frame.transpose() * frame - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (defect < kOrthonormal) return frame;
  return Eigen::Matrix3d::Identity();
}

}  // namespace

void find_vertex_frames(std::span<const ElementBlock> blocks, const linear::VertexField& x,
                        std::vector<Eigen::Matrix3d>& frames) {
  for (Eigen::Matrix3d& frame : frames) frame.setZero();
  LaneFrames lanes;
  for (const ElementBlock& block : blocks) {
    frames_at(block, x, lanes);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (block.area[l] == 0.0) continue;
      Eigen::Matrix3d weighted;
      weighted.col(0) = Eigen::Vector3d(lanes.R1[0][l], lanes.R1[1][l], lanes.R1[2][l]);
      weighted.col(1) = Eigen::Vector3d(lanes.R2[0][l], lanes.R2[1][l], lanes.R2[2][l]);
      weighted.col(2) = weighted.col(0).cross(weighted.col(1));
      weighted *= block.area[l];
      for (std::size_t k = 0; k < 3; ++k) frames[static_cast<std::size_t>(block.vertex[k][l])] += weighted;
    }
  }
  for (Eigen::Matrix3d& frame : frames) frame = orthonormal(frame);
}

}  // namespace kerf::fem
