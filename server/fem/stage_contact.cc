#include "server/fem/stage_contact.h"

#include <limits>
#include <utility>

namespace kerf::fem {
namespace {

Eigen::Vector3d tangential(const SurfaceGap& surface, const Eigen::Vector3d& u) {
  return u - u.dot(surface.normal) * surface.normal;
}

}  // namespace

void StageContact::resize(int num_vertices) {
  entries_.clear();
  entries_.reserve(ContactConstraint::kMaxGaps * static_cast<std::size_t>(num_vertices));
  before_.reserve(entries_.capacity());
}

void StageContact::begin(const ContactConstraint* contact, const Model& model, double d,
                         const Eigen::Matrix3Xd& start) {
  contact_ = contact;
  model_ = &model;
  start_ = &start;
  inertia_ = 1.0 / (d * d);
  membrane_ = model.membrane_law().trace();
  entries_.clear();
}

double StageContact::stiffness(int vertex) const {
  return kStiffening * (inertia_ * model_->mass()[static_cast<std::size_t>(vertex)] + membrane_);
}

void StageContact::predict(const Eigen::Matrix3Xd& x, Eigen::Matrix3Xd& step) {
  entries_.clear();
  if (contact_ == nullptr) return;
  std::array<SurfaceGap, ContactConstraint::kMaxGaps> gaps;
  for (int i = 0; i < x.cols(); ++i) {
    const std::size_t found = contact_->find_gaps(i, x.col(i), step.col(i).norm(), gaps);
    for (std::size_t k = 0; k < found; ++k) {
      const double depth = -gaps[k].gap - step.col(i).dot(gaps[k].normal);
      if (depth <= 0.0) continue;
      Entry entry;
      entry.vertex = i;
      entry.surface = gaps[k];
      entry.stiffness = stiffness(i);
      step.col(i) += depth * gaps[k].normal;
      entry.slid = tangential(gaps[k], x.col(i) + step.col(i) - start_->col(i));
      const double hold = gaps[k].friction * depth;  // m, how far friction could have pulled back
      const double slid = entry.slid.norm();
      entry.sticks = hold > 0.0 && slid <= hold;
      if (entry.sticks) {
        step.col(i) -= entry.slid;
      } else if (hold > 0.0) {
        entry.limit = hold * inertia_ * model_->mass()[static_cast<std::size_t>(i)];
        entry.drag = -entry.limit / slid * entry.slid;
        entry.force = entry.drag;
      }
      entries_.push_back(entry);
    }
  }
}

void StageContact::detect(const Eigen::Matrix3Xd& x, Decide decide) {
  std::swap(entries_, before_);
  entries_.clear();
  if (contact_ == nullptr) return;
  std::array<SurfaceGap, ContactConstraint::kMaxGaps> gaps;
  auto known = before_.cbegin();
  for (int i = 0; i < x.cols(); ++i) {
    const bool any_known = known != before_.cend() && known->vertex == i;
    const double reach = any_known && decide == Decide::kNew ? std::numeric_limits<double>::infinity() : 0.0;
    const std::size_t found = contact_->find_gaps(i, x.col(i), reach, gaps);
    for (std::size_t k = 0; k < found; ++k) {
      while (known != before_.cend() && known->vertex == i && known->surface.surface < gaps[k].surface) ++known;
      const bool is_known = known != before_.cend() && known->vertex == i && known->surface.surface == gaps[k].surface;
      if (gaps[k].gap >= 0.0 && !(is_known && decide == Decide::kNew)) continue;
      Entry entry = is_known ? *known : Entry{};
      entry.vertex = i;
      entry.surface = gaps[k];
      entry.stiffness = stiffness(i);
      entry.force = -entry.stiffness * gaps[k].gap * gaps[k].normal;
      const Eigen::Vector3d slid = tangential(gaps[k], x.col(i) - start_->col(i));
      if (decide != Decide::kNew) decide_friction(decide, is_known, slid, entry);
      entry.force += entry.sticks ? Eigen::Vector3d(-entry.stiffness * slid) : entry.drag;
      entries_.push_back(entry);
    }
    while (known != before_.cend() && known->vertex == i) ++known;
  }
}

void StageContact::decide_friction(Decide decide, bool known, const Eigen::Vector3d& slid, Entry& entry) const {
  // A slide that turned round went through zero, where friction would have held it.
  const bool turned = decide == Decide::kAnew && known && !entry.sticks && entry.slid.dot(slid) < 0.0;
  entry.limit = entry.surface.friction * entry.stiffness * -entry.surface.gap;
  entry.slid = slid;
  const double length = slid.norm();
  entry.sticks = entry.limit > 0.0 && (turned || entry.stiffness * length <= entry.limit);
  entry.drag.setZero();
  if (!entry.sticks && entry.limit > 0.0) entry.drag = -entry.limit / length * slid;
}

void StageContact::add_forces(double scale, Eigen::Matrix3Xd& forces) const {
  for (const Entry& entry : entries_) forces.col(entry.vertex) += scale * entry.force;
}

void StageContact::add_stiffness(double scale, BlockMatrix& matrix) const {
  for (const Entry& entry : entries_) {
    const Eigen::Vector3d& n = entry.surface.normal;
    const double k = scale * entry.stiffness;
    if (entry.sticks) {
      matrix.block(matrix.diagonal(entry.vertex)).diagonal().array() += k;
    } else {
      matrix.block(matrix.diagonal(entry.vertex)) += k * n * n.transpose();
    }
  }
}

double StageContact::potential(const Eigen::Matrix3Xd& x) const {
  if (contact_ == nullptr) return 0.0;
  double potential = 0.0;
  std::array<SurfaceGap, ContactConstraint::kMaxGaps> gaps;
  for (int i = 0; i < x.cols(); ++i) {
    const std::size_t found = contact_->find_gaps(i, x.col(i), 0.0, gaps);
    for (std::size_t k = 0; k < found; ++k) potential += 0.5 * stiffness(i) * gaps[k].gap * gaps[k].gap;
  }
  for (const Entry& entry : entries_) {
    const double slid = tangential(entry.surface, x.col(entry.vertex) - start_->col(entry.vertex)).norm();
    const double reach = entry.limit / entry.stiffness;  // m, how far a vertex that sticks gives way
    potential += slid <= reach ? 0.5 * entry.stiffness * slid * slid : entry.limit * (slid - 0.5 * reach);
  }
  return potential;
}

}  // namespace kerf::fem
