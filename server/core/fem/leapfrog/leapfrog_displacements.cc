// Members of LeapfrogSweep for steps by displacements since their beginning.
#include <algorithm>
#include <cmath>

#include "server/base/check.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/leapfrog/leapfrog_sweep.h"

namespace kerf::fem {

using mesh::TriangleId;
using mesh::VertexId;

template <typename T>
bool LeapfrogSweep<T>::set_start(const Model& model, const State& state) {
  constexpr double kMostStrained = 0.25;  // -, largest entry of F^T F - I; beyond it, rounding of this matrix to floats
                                          // matters
  KERF_DCHECK(model.materials().membrane_law() == MembraneLaw::kCorotational, "Green's has no displacements");
  start_.setZero();
  for (VertexId v = 0; v < layout_->num_vertices(); ++v) {
    if (takes_part_[static_cast<std::size_t>(v)] != 0) start_.col(v) = state.x.col(v);
  }
  double largest = 0.0;
  const auto set = [&](TriangleId slot, StartLanes<T>& to, std::size_t l) {
    Eigen::Matrix<double, 3, 2> F = Eigen::Matrix<double, 3, 2>::Zero();
    Eigen::Matrix2d E = Eigen::Matrix2d::Zero();
    if (slot != mesh::kNone) {
      const auto s = static_cast<std::size_t>(slot);
      const ElementBlock& block = model.element_blocks()[s / kLanes];
      const std::size_t from = s % kLanes;
      const Eigen::Vector3d x0 = start_.col(block.vertex[0][from]);
      const Eigen::Vector3d d1 = start_.col(block.vertex[1][from]) - x0;
      const Eigen::Vector3d d2 = start_.col(block.vertex[2][from]) - x0;
      for (std::size_t c = 0; c < 2; ++c) {
        F.col(static_cast<Eigen::Index>(c)) = block.g1[c][from] * d1 + block.g2[c][from] * d2;
      }
      E = F.transpose() * F - Eigen::Matrix2d::Identity();
      largest = std::max(largest, E.cwiseAbs().maxCoeff());
    }
    for (std::size_t c = 0; c < 3; ++c) {
      to.f1[c].lane[l] = static_cast<T>(F(static_cast<Eigen::Index>(c), 0));
      to.f2[c].lane[l] = static_cast<T>(F(static_cast<Eigen::Index>(c), 1));
    }
    to.e11.lane[l] = static_cast<T>(E(0, 0));
    to.e22.lane[l] = static_cast<T>(E(1, 1));
    to.e12.lane[l] = static_cast<T>(E(0, 1));
  };
  const auto num_lanes = static_cast<VertexId>(linear::kBlockLanes * layout_->num_blocks());
  for (VertexId v = 0; !quad_start_.empty() && v < num_lanes; ++v) {
    const auto i = static_cast<std::size_t>(v);
    for (const int kind : {0, 1}) {
      set(layout_->quad_slot(kind, v), quad_start_[2 * (i / linear::kBlockLanes) + static_cast<std::size_t>(kind)],
          i % linear::kBlockLanes);
    }
  }
  for (std::size_t lane = 0; lane < layout_->lanes().size(); ++lane) {
    const bool is_fine = fine_.place_of_lane[lane] != mesh::kNone;
    set(is_fine ? mesh::kNone : layout_->lanes()[lane], irregular_start_[lane / linear::kBlockLanes],
        irregular_lane<T>(lane % linear::kBlockLanes));
  }
  if (!(largest <= kMostStrained)) return false;
  if (!model.materials().has_bending()) return true;
  bending_start_.setZero();
  add_bending_forces(model.bending().rows(), start_, bending_start_);
  return true;
}

template <typename T>
bool LeapfrogSweep<T>::set_extra_forces(const Model& model, const LeapfrogKick& kick) {
  const bool adds_bending = is_by_displacements() && kick.bending > 0.0 && model.materials().has_bending();
  if (kick.forces == nullptr && !adds_bending) return false;
  const double times = kick.bending / kick.duration;
  T* const extra = extra_.front().lane.data();
  for (VertexId v = 0; v < layout_->num_vertices(); ++v) {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    if (kick.forces != nullptr) force = kick.forces->col(v);
    if (adds_bending) force += times * bending_start_.col(v);
    for (Eigen::Index c = 0; c < 3; ++c) extra[4 * v + c] = static_cast<T>(force[c]);
  }
  return true;
}

template bool LeapfrogSweep<float>::set_start(const Model& model, const State& state);
template bool LeapfrogSweep<double>::set_start(const Model& model, const State& state);
template bool LeapfrogSweep<float>::set_extra_forces(const Model& model, const LeapfrogKick& kick);
template bool LeapfrogSweep<double>::set_extra_forces(const Model& model, const LeapfrogKick& kick);

}  // namespace kerf::fem
