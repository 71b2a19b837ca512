#pragma once

#include <array>

#include <Eigen/Core>

#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"

namespace kerf::sheet {

// Measures the travel of every vertex in a window of time. Also measures the motion of its mean position from each
// third of the window to the next. A vertex that trembles in place hardly moves its mean.
class MotionWindow {
 public:
  // `length`: s, > 0
  explicit MotionWindow(double length) : length_(length) {}

  void make_room(Eigen::Index num_vertices);
  void begin(const Eigen::Matrix3Xd& x);
  // Takes positions (3 x V, m) `dt` (s) after those before. True: the window is complete; begin() another.
  bool add(const Eigen::Matrix3Xd& x, double dt);
  // Estimates, in m, how far a vertex may be from its last place within `horizon` (s): as far as it has been from
  // there, and what it goes further if it keeps its pace. One that slowed down from the first two thirds to the last
  // two slows down further at that rate if `slows` is true.
  [[nodiscard]] double expected_motion(double horizon, bool slows) const;
  [[nodiscard]] double length() const { return length_; }

 private:
  double length_;
  double time_ = 0.0;                     // s
  Eigen::Index num_vertices_ = 0;         // arrays have room for more
  Eigen::Matrix3Xd start_;                // m
  std::array<int, 3> num_ticks_{};        // of each third
  std::array<Eigen::Matrix3Xd, 3> sums_;  // m, of places less start_ in each third
  Eigen::Matrix3Xd last_, low_, high_;    // m, less start_: the last places, and the bounds of all
};

// Brings a sheet that nothing disturbs any more to rest, and detects when it is at rest.
//
// Cloth in air swings itself still within seconds, by losses that a material's Rayleigh damping hardly has at low
// frequencies. So a calm sheet is damped a little: its velocities decay at up to kDampingRate times the rate of a
// pendulum of its size. A sheet is calm if nothing has disturbed it for kCalmAfter seconds and its kinetic energy is
// low. That is, the mean over about a second is below the energy that lifts it by kCalmHeight times its size. Other
// sheets are not damped.
//
// A sheet is at rest if no vertex is expected to move by more than kTolerance in the next minute. Either of two windows
// can show that. A sheet that grows still soon passes the short one; the long one is for sheets that tremble. A damped
// sheet that slows down in two successive windows of one length, each about a swing or longer, is taken to slow down
// further. Speeds are a poorer measure: a vertex that a body holds has some within each substep, and stays where it is.
class RestWatch {
 public:
  static constexpr double kCalmAfter = 5.0;      // s
  static constexpr double kCalmHeight = 4.0e-5;  // -, of the size
  static constexpr double kDampingRate = 0.8;    // -, of sqrt(g / size)
  static constexpr double kShortWindow = 2.0;    // s
  static constexpr double kLongWindow = 8.0;     // s
  static constexpr double kHorizon = 60.0;       // s
  static constexpr double kSwing = 6.0;          // -, least window over sqrt(size / g) to separate slowing and swinging
  static constexpr double kTolerance = 9.0e-5;   // m

  struct Tick {
    double gravity = 0.0;  // m/s^2, >= 0
    double dt = 0.0;       // s
    bool damps = true;     // the sheet may be damped
  };

  // `size`: m, the larger side of the sheet as built.
  explicit RestWatch(double size) : size_(size) {}

  // Allocates what after_tick() needs.
  void make_room(Eigen::Index num_vertices);
  // Notes that something other than the sheet's own motion changed it, or may change it.
  void disturb();
  // Must be called after each tick, with the state that it made. Damps the state if the sheet is calm.
  void after_tick(const fem::Model& model, const Tick& tick, fem::State& state);

  // Returns true if nothing has disturbed the sheet for kCalmAfter, it is slow for its weight, and it is damped.
  [[nodiscard]] bool is_calm() const { return is_calm_; }
  [[nodiscard]] bool is_at_rest() const { return is_at_rest_; }

 private:
  double size_;
  double calm_time_ = 0.0;  // s, simulated time since the last disturb()
  double energy_ = 0.0;     // J, mean kinetic energy over about a second
  bool is_calm_ = false;
  bool is_measuring_ = false;
  bool is_at_rest_ = false;
  std::array<MotionWindow, 2> windows_{MotionWindow(kShortWindow), MotionWindow(kLongWindow)};
  std::array<bool, 2> settles_{};  // by window: the last one predicted rest, if slowing continues
};

}  // namespace kerf::sheet
