#include "server/core/sheet/rest_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/base/elementary.h"

namespace kerf::sheet {

void MotionWindow::make_room(Eigen::Index num_vertices) {
  if (num_vertices <= start_.cols()) return;
  const Eigen::Index room = num_vertices + num_vertices / 4;  // extra room, so that cuts seldom allocate memory in
                                                              // proportion to the sheet
  for (Eigen::Matrix3Xd* field : {&start_, &last_, &low_, &high_}) field->resize(3, room);
  for (Eigen::Matrix3Xd& sum : sums_) sum.resize(3, room);
}

void MotionWindow::begin(const Eigen::Matrix3Xd& x) {
  time_ = 0.0;
  num_ticks_.fill(0);
  num_vertices_ = x.cols();
  start_.leftCols(num_vertices_) = x;
  for (Eigen::Matrix3Xd& sum : sums_) sum.setZero();
  for (Eigen::Matrix3Xd* field : {&last_, &low_, &high_}) field->setZero();
}

bool MotionWindow::add(const Eigen::Matrix3Xd& x, double dt) {
  time_ += dt;
  // Gives every third at least one tick, even if ticks are long.
  const auto begun = static_cast<std::size_t>(std::ranges::find(num_ticks_, 0) - num_ticks_.begin());
  const auto third =
      std::min(static_cast<std::size_t>(std::clamp(3.0 * (time_ - 0.5 * dt) / length_, 0.0, 2.0)), begun);
  ++num_ticks_[third];
  Eigen::Matrix3Xd& sum = sums_[third];
  for (Eigen::Index v = 0; v < num_vertices_; ++v) {
    const Eigen::Vector3d moved = x.col(v) - start_.col(v);
    sum.col(v) += moved;
    last_.col(v) = moved;
    low_.col(v) = low_.col(v).cwiseMin(moved);
    high_.col(v) = high_.col(v).cwiseMax(moved);
  }
  return time_ >= length_ * (1.0 - 1.0e-9) && num_ticks_.back() > 0;
}

double MotionWindow::extent_at(Eigen::Index v) const {
  return (high_.col(v) - last_.col(v)).cwiseMax(last_.col(v) - low_.col(v)).norm();
}

Eigen::Vector3d MotionWindow::mean_at(Eigen::Index v, std::size_t third) const {
  return sums_[third].col(v) / num_ticks_[third];
}

bool MotionWindow::stays_within(double extent, double drift) const {
  const double moved = drift * length_ / 3.0;
  for (Eigen::Index v = 0; v < num_vertices_; ++v) {
    if (!(extent_at(v) <= extent) || !((mean_at(v, 2) - mean_at(v, 1)).norm() <= moved)) return false;
  }
  return true;
}

double MotionWindow::expected_motion(double horizon, bool slows) const {
  constexpr double kSlowing = 0.95;  // -; a drift that keeps more than this from third to third is not slowing down
  constexpr double kSafety = 1.5;    // -, factor on the estimate of the motion to come
  const double steps = horizon / (length_ / 3.0);
  double expected = 0.0;
  for (Eigen::Index v = 0; v < num_vertices_; ++v) {
    const Eigen::Vector3d middle = mean_at(v, 1);
    const double before = (middle - mean_at(v, 0)).norm();
    const double drift = (mean_at(v, 2) - middle).norm();
    const bool is_slowing = slows && drift < kSlowing * before;
    const double to_come = is_slowing ? std::min(kSafety / (1.0 - drift / before), steps) : steps;
    expected = std::max(expected, extent_at(v) + drift * to_come);
  }
  return expected;
}

void RestWatch::make_room(Eigen::Index num_vertices) {
  for (MotionWindow& window : windows_) window.make_room(num_vertices);
}

void RestWatch::disturb() {
  calm_time_ = 0.0;
  is_calm_ = is_measuring_ = is_at_rest_ = false;
  settles_.fill(false);
}

void RestWatch::after_tick(const fem::Model& model, const Tick& tick, fem::State& state) {
  constexpr double kMeanOver = 1.0;  // s
  double kinetic = 0.0;
  for (Eigen::Index i = 0; i < state.v.cols(); ++i) {
    kinetic += 0.5 * model.mass()[static_cast<std::size_t>(i)] * state.v.col(i).squaredNorm();
  }
  const double share = std::min(tick.dt / kMeanOver, 1.0), touched = tick.touches ? 1.0 : 0.0;
  energy_ = calm_time_ == 0.0 ? kinetic : energy_ + share * (kinetic - energy_);
  touched_ = calm_time_ == 0.0 ? touched : touched_ + share * (touched - touched_);
  const bool touches = touched_ > 0.5;
  calm_time_ += tick.dt;
  const double calm_energy =
      (touches ? kTouchingEnergy : 1.0) * kCalmHeight * size_ * model.masses().total() * tick.gravity;
  // The weight gives the scale for speeds. Without weight every sheet counts as slow.
  const bool is_slow = tick.gravity == 0.0 || energy_ < calm_energy;
  if (!is_slow) {
    is_calm_ = is_measuring_ = is_at_rest_ = false;
    settles_.fill(false);
    return;
  }
  is_calm_ = tick.damps && tick.gravity > 0.0 && calm_time_ >= kCalmAfter;
  if (is_calm_) {
    const double rate = kDampingRate * std::sqrt(tick.gravity / size_) * (1.0 - energy_ / calm_energy);
    state.v *= exponential(-rate * tick.dt);
  }
  if (!is_measuring_) {
    is_measuring_ = true;
    for (MotionWindow& window : windows_) window.begin(state.x);
    return;
  }
  for (std::size_t k = 0; k < windows_.size(); ++k) {
    MotionWindow& window = windows_[k];
    if (!window.add(state.x, tick.dt)) continue;
    // Requires two successive windows, as noise may look like slowing down in one.
    const bool settled =
        std::exchange(settles_[k], is_calm_ && window.length() * std::sqrt(tick.gravity / size_) >= kSwing &&
                                       window.expected_motion(kHorizon, true) <= kTolerance);
    const bool creeps = touches && is_calm_ && window.stays_within(kTouchingExtent, kTouchingDrift);
    is_at_rest_ =
        is_at_rest_ || creeps || (settled && settles_[k]) || window.expected_motion(kHorizon, false) <= kTolerance;
    window.begin(state.x);
  }
}

}  // namespace kerf::sheet
