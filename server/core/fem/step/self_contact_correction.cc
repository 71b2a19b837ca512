#include "server/core/fem/step/self_contact_correction.h"

#include <algorithm>
#include <cstddef>

#include "server/core/fem/element/contact_constraint.h"

namespace kerf::fem {
namespace {

constexpr int kParts = 64;  // of a substep; contact chooses how many pass between its phases

}  // namespace

void SelfContactCorrection::resize(Eigen::Index num_vertices) {
  if (way_.cols() == num_vertices) return;
  const auto count = static_cast<std::size_t>(num_vertices);
  for (linear::VertexField* field : {&motion_.x, &motion_.v, &way_}) field->resize(num_vertices);
  inverse_mass_.resize(count);
  is_moved_.assign(count, 0);
  moved_.clear();
  moved_.reserve(count);
}

bool SelfContactCorrection::correct(const Model& model, const Loads& loads, double h, const linear::VertexField& start,
                                    ContactConstraint& contact, linear::VertexField& x) {
  resize(x.cols());
  const std::span<const double> inverse_mass = model.inverse_mass();
  inverse_mass_.assign(inverse_mass.begin(), inverse_mass.end());
  for (const Pin& pin : loads.pins) inverse_mass_[static_cast<std::size_t>(pin.vertex)] = 0.0;
  way_ = (x - start) / h;
  motion_.x = start;
  motion_.v = way_;
  const double part = h / kParts;
  // The way has the effect of all forces already.
  collect(contact.begin_self_contact(part, kParts, Eigen::Vector3d::Zero(), inverse_mass_, none_, motion_));
  for (int done = 0; done < kParts;) {
    const int next = std::min(contact.next_self_contact(), kParts);
    motion_.x += (next - done) * part * motion_.v;
    done = next;
    collect(contact.make_self_contact(motion_));
  }
  if (moved_.empty()) return false;
  way_ = motion_.v - way_;
  for (const mesh::VertexId v : moved_) {
    x.col(v) = motion_.x.col(v);
    is_moved_[static_cast<std::size_t>(v)] = 0;
  }
  moved_.clear();
  return true;
}

void SelfContactCorrection::collect(std::span<const mesh::VertexId> moved) {
  for (const mesh::VertexId v : moved) {
    std::uint8_t& is_moved = is_moved_[static_cast<std::size_t>(v)];
    if (is_moved == 0) moved_.push_back(v);
    is_moved = 1;
  }
}

}  // namespace kerf::fem
