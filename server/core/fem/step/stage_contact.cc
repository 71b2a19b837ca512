#include "server/core/fem/step/stage_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {
namespace {

Eigen::Vector3d tangential(const SurfaceGap& surface, const Eigen::Vector3d& u) {
  return u - u.dot(surface.normal) * surface.normal;
}

}  // namespace

void StageContact::resize(int num_vertices) {
  entries_.clear();
  const std::size_t room = ContactConstraint::kMaxGaps * static_cast<std::size_t>(num_vertices);
  if (room <= entries_.capacity()) return;
  entries_.reserve(room + room / 2);  // a large block that is never written takes no memory
  before_.reserve(entries_.capacity());
}

void StageContact::begin(const ContactConstraint* contact, const Model& model, double d,
                         const linear::VertexField& start) {
  contact_ = contact;
  model_ = &model;
  start_ = &start;
  inertia_ = 1.0 / (d * d);
  membrane_ = model.materials().largest_membrane_trace();
  is_penalty_ = false;
  entries_.clear();
}

void StageContact::begin_penalty() {
  is_penalty_ = true;
  entries_.clear();
}

double StageContact::stiffness(int vertex) const {
  return kStiffening * (inertia_ * model_->mass()[static_cast<std::size_t>(vertex)] + membrane_);
}

void StageContact::predict(const linear::VertexField& x, const linear::VertexField& impulse,
                           linear::VertexField& step) {
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
      const Eigen::Vector3d slid = tangential(gaps[k], x.col(i) + step.col(i) - start_->col(i));
      const Eigen::Vector3d drive = inertia_ * tangential(gaps[k], impulse.col(i));
      entry.surface.gap = 0.0;  // at the end of the step
      entry.normal = inertia_ * std::max(0.0, -impulse.col(i).dot(gaps[k].normal));
      entry.limit = gaps[k].friction * entry.normal;
      entry.sticks = entry.limit > 0.0 && drive.norm() <= entry.limit;
      if (entry.sticks) {
        step.col(i) -= slid;
      } else if (entry.limit > 0.0) {
        entry.slid = slid;
        entry.friction = -entry.limit * drive.normalized();
        entry.force = entry.friction;
      }
      entry.force += entry.normal * gaps[k].normal;
      entries_.push_back(entry);
    }
  }
}

void StageContact::detect(const linear::VertexField& x) {
  std::swap(entries_, before_);
  entries_.clear();
  if (contact_ == nullptr) return;
  std::array<SurfaceGap, ContactConstraint::kMaxGaps> gaps;
  auto known = before_.cbegin();
  const auto skip_to = [&](int vertex, int surface) {
    const auto is_before = [&](const Entry& entry) {
      return std::pair(entry.vertex, entry.surface.surface) < std::pair(vertex, surface);
    };
    while (known != before_.cend() && is_before(*known)) ++known;
  };
  for (int i = 0; i < x.cols(); ++i) {
    skip_to(i, 0);
    const bool any_known = known != before_.cend() && known->vertex == i;
    const double reach = any_known && !is_penalty_ ? std::numeric_limits<double>::infinity() : 0.0;
    const std::size_t found = contact_->find_gaps(i, x.col(i), reach, gaps);
    for (std::size_t k = 0; k < found; ++k) {
      skip_to(i, gaps[k].surface);
      const bool is_known = known != before_.cend() && known->vertex == i && known->surface.surface == gaps[k].surface;
      if (gaps[k].gap >= 0.0 && (is_penalty_ || !is_known)) continue;
      Entry entry = is_known ? *known : Entry{};
      entry.vertex = i;
      entry.surface = gaps[k];
      entry.stiffness = stiffness(i);
      if (is_penalty_) entry.normal = -entry.stiffness * gaps[k].gap;
      double limit = gaps[k].friction * std::max(0.0, entry.normal);
      constexpr double kFollow = 0.5;  // -; following all of a penalty oscillates on a curved surface
      if (is_penalty_ && entry.limit > 0.0) limit = entry.limit + kFollow * (limit - entry.limit);
      update_friction(tangential(gaps[k], x.col(i) - start_->col(i)), limit, entry);
      entry.force += entry.normal * gaps[k].normal;
      entries_.push_back(entry);
    }
  }
}

void StageContact::update_friction(const Eigen::Vector3d& slid, double limit, Entry& entry) {
  const double limit_before = entry.limit;
  Eigen::Vector3d predicted(0.0, 0.0, 0.0);
  if (limit_before > 0.0) {
    const double yield = std::max(entry.slid.norm(), limit_before / entry.stiffness);
    predicted = -limit_before / yield * slid;
    if (!entry.sticks) predicted -= entry.slid.dot(slid - entry.slid) / (yield * yield) * entry.friction;
    predicted /= std::max(limit_before, predicted.norm());
  }
  entry.limit = limit;
  entry.slid = slid;
  const double length = slid.norm();
  entry.sticks = limit > 0.0 && entry.stiffness * length <= limit;
  entry.force.setZero();
  if (entry.sticks) {
    entry.force = -entry.stiffness * slid;
  } else if (limit > 0.0) {
    entry.force = -limit / length * slid;
  }
  entry.friction = limit_before > 0.0 ? Eigen::Vector3d(limit * predicted) : entry.force;
}

void StageContact::release(double scale, linear::VertexField& forces) {
  std::erase_if(entries_, [&](const Entry& entry) {
    if (entry.normal > 0.0) return false;
    forces.col(entry.vertex) -= scale * entry.force;
    return true;
  });
}

void StageContact::follow(const linear::VertexField& step, double share) {
  if (is_penalty_) return;
  for (Entry& entry : entries_) {
    const SurfaceGap& surface = entry.surface;
    entry.normal -= entry.stiffness * (share * surface.gap + surface.normal.dot(step.col(entry.vertex)));
  }
}

double StageContact::slope(const linear::VertexField& step, double share) const {
  double sum = 0.0;
  for (const Entry& entry : entries_) {
    const Eigen::Vector3d& n = entry.surface.normal;
    const Eigen::Vector3d along = step.col(entry.vertex);
    const double rise = n.dot(along);
    const Eigen::Vector3d slid = entry.slid + share * (along - rise * n);
    const double yield = std::max(slid.norm(), entry.limit / entry.stiffness);
    sum += rise * (entry.normal - entry.stiffness * (entry.surface.gap + share * rise));
    if (entry.limit > 0.0) sum -= entry.limit / yield * slid.dot(along);
  }
  return sum;
}

double StageContact::share_without_overshoot(const linear::VertexField& step, double scale, double before,
                                             double after) const {
  constexpr double kAllowed = 0.2;  // -, slope at the end over that at the start which is left alone
  constexpr double kLeast = 1e-4;   // -, least share
  constexpr int kBisections = 20;
  if (friction_norm() == 0.0) return 1.0;
  const auto slope_at = [&](double share) {
    return (1.0 - share) * before + share * after + scale * slope(step, share);
  };
  if (slope_at(1.0) >= -kAllowed * std::abs(slope_at(0.0))) return 1.0;
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (slope_at(middle) >= 0.0 ? low : high) = middle;
  }
  return std::max(low, kLeast);
}

void StageContact::project(linear::VertexField& x) {
  if (is_penalty_) return;
  for (Entry& entry : entries_) {
    if (!(entry.normal > 0.0)) continue;
    x.col(entry.vertex) -= entry.surface.gap * entry.surface.normal;
    entry.surface.gap = 0.0;
    if (!entry.sticks) continue;
    x.col(entry.vertex) -= entry.slid;
    entry.slid.setZero();
  }
}

double StageContact::normal_norm() const {
  double sum = 0.0;
  for (const Entry& entry : entries_) sum += entry.normal * entry.normal;
  return std::sqrt(sum);
}

double StageContact::friction_norm() const {
  double sum = 0.0;
  for (const Entry& entry : entries_) sum += entry.limit * entry.limit;
  return std::sqrt(sum);
}

double StageContact::gap_norm() const {
  double sum = 0.0;
  for (const Entry& entry : entries_) {
    const double force = entry.stiffness / kStiffening * entry.surface.gap;
    sum += force * force;
  }
  return std::sqrt(sum);
}

double StageContact::work(const linear::VertexField& step) const {
  double sum = 0.0;
  for (const Entry& entry : entries_) sum += entry.force.dot(step.col(entry.vertex));
  return sum;
}

void StageContact::add_gap_forces(double scale, linear::VertexField& forces) const {
  if (is_penalty_) return;
  for (const Entry& entry : entries_) {
    forces.col(entry.vertex) -= scale * entry.stiffness * entry.surface.gap * entry.surface.normal;
  }
}

void StageContact::add_forces(double scale, linear::VertexField& forces) const {
  for (const Entry& entry : entries_) forces.col(entry.vertex) += scale * entry.force;
}

void StageContact::add_stiffness(double scale, linear::BlockMatrix& matrix) const {
  for (const Entry& entry : entries_) {
    Eigen::Matrix3d& block = matrix.block(matrix.diagonal(entry.vertex));
    const Eigen::Vector3d& n = entry.surface.normal;
    const double k = scale * entry.stiffness;
    if (entry.sticks) {
      block.diagonal().array() += k;
      continue;
    }
    block += k * n * n.transpose();
    if (entry.limit == 0.0) continue;
    const Eigen::Vector3d t = entry.slid.normalized();
    const Eigen::Vector3d p = entry.friction / entry.limit;
    const double yield = std::max(entry.slid.norm(), entry.limit / entry.stiffness);
    block += scale * entry.limit / yield *
             (Eigen::Matrix3d::Identity() - n * n.transpose() + 0.5 * (p * t.transpose() + t * p.transpose()));
  }
}

void StageContact::stop(linear::VertexField& v) const {
  for (const Entry& entry : entries_) {
    const Eigen::Vector3d& n = entry.surface.normal;
    if (!(entry.force.dot(n) > 0.0)) continue;
    v.col(entry.vertex) -= entry.sticks ? Eigen::Vector3d(v.col(entry.vertex)) : v.col(entry.vertex).dot(n) * n;
  }
}

double StageContact::potential(const linear::VertexField& x) const {
  if (contact_ == nullptr) return 0.0;
  double potential = 0.0;
  std::array<SurfaceGap, ContactConstraint::kMaxGaps> gaps;
  for (int i = 0; i < x.cols(); ++i) {
    const std::size_t found = contact_->find_gaps(i, x.col(i), 0.0, gaps);
    for (std::size_t k = 0; k < found; ++k) potential += 0.5 * stiffness(i) * gaps[k].gap * gaps[k].gap;
  }
  for (const Entry& entry : entries_) {
    const double slid = tangential(entry.surface, x.col(entry.vertex) - start_->col(entry.vertex)).norm();
    const double reach = entry.limit / entry.stiffness;  // m, largest displacement of a vertex that sticks
    potential += slid <= reach ? 0.5 * entry.stiffness * slid * slid : entry.limit * (slid - 0.5 * reach);
  }
  return potential;
}

}  // namespace kerf::fem
