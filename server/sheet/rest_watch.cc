#include "server/sheet/rest_watch.h"

#include <algorithm>
#include <cmath>

namespace kerf::sheet {

void MotionWindow::make_room(Eigen::Index num_vertices) {
  if (num_vertices <= start_.cols()) return;
  const Eigen::Index room = num_vertices + num_vertices / 4;  // so that cuts seldom allocate what grows with the sheet
  start_.resize(3, room);
  first_sum_.resize(3, room);
  second_sum_.resize(3, room);
  largest_.resize(room);
}

void MotionWindow::begin(const Eigen::Matrix3Xd& x) {
  time_ = 0.0;
  num_first_ = num_second_ = 0;
  num_vertices_ = x.cols();
  start_.leftCols(num_vertices_) = x;
  first_sum_.setZero();
  second_sum_.setZero();
  largest_.setZero();
}

bool MotionWindow::add(const Eigen::Matrix3Xd& x, double dt) {
  time_ += dt;
  const bool is_first = time_ <= 0.5 * length_;
  ++(is_first ? num_first_ : num_second_);
  Eigen::Matrix3Xd& sum = is_first ? first_sum_ : second_sum_;
  for (Eigen::Index v = 0; v < num_vertices_; ++v) {
    const Eigen::Vector3d moved = x.col(v) - start_.col(v);
    sum.col(v) += moved;
    largest_[v] = std::max(largest_[v], moved.squaredNorm());
  }
  return time_ >= length_ * (1.0 - 1.0e-9) && num_first_ > 0 && num_second_ > 0;
}

double MotionWindow::expected_motion(double foresight) const {
  double expected = 0.0;
  for (Eigen::Index v = 0; v < num_vertices_; ++v) {
    const double drift = (second_sum_.col(v) / num_second_ - first_sum_.col(v) / num_first_).norm();
    expected = std::max(expected, std::sqrt(largest_[v]) + drift * foresight / (0.5 * length_));
  }
  return expected;
}

void RestWatch::make_room(Eigen::Index num_vertices) {
  short_window_.make_room(num_vertices);
  long_window_.make_room(num_vertices);
}

void RestWatch::disturb() {
  calm_time_ = 0.0;
  is_measuring_ = false;
  is_at_rest_ = false;
}

void RestWatch::after_tick(const fem::Model& model, const Tick& tick, fem::State& state) {
  constexpr double kMeanOver = 1.0;  // s
  double kinetic = 0.0;
  for (Eigen::Index i = 0; i < state.v.cols(); ++i) {
    kinetic += 0.5 * model.mass()[static_cast<std::size_t>(i)] * state.v.col(i).squaredNorm();
  }
  energy_ = calm_time_ == 0.0 ? kinetic : energy_ + std::min(tick.dt / kMeanOver, 1.0) * (kinetic - energy_);
  calm_time_ += tick.dt;
  const double calm_energy = kCalmHeight * size_ * model.total_mass() * tick.gravity;
  // Without weight nothing says how fast is slow.
  const bool is_slow = tick.gravity == 0.0 || energy_ < calm_energy;
  if (!is_slow) {
    is_measuring_ = is_at_rest_ = false;
    return;
  }
  if (tick.damps && tick.gravity > 0.0 && calm_time_ >= kCalmAfter) {
    const double rate = kDampingRate * std::sqrt(tick.gravity / size_) * (1.0 - energy_ / calm_energy);
    state.v *= std::exp(-rate * tick.dt);
  }
  if (!is_measuring_) {
    is_measuring_ = true;
    short_window_.begin(state.x);
    long_window_.begin(state.x);
    return;
  }
  for (MotionWindow* window : {&short_window_, &long_window_}) {
    if (!window->add(state.x, tick.dt)) continue;
    is_at_rest_ = is_at_rest_ || window->expected_motion(kForesight) <= kTolerance;
    window->begin(state.x);
  }
}

}  // namespace kerf::sheet
