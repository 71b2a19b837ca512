#pragma once

#include <array>

#include <Eigen/Core>

#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// Measures the motion of all vertices in a window of time: the extent of each vertex's path, and its mean position in
// each third of the window. The mean position of a vertex that trembles in place hardly moves.
class MotionWindow {
 public:
  // `length`: length of the window, s, > 0.
  explicit MotionWindow(double length) : length_(length) {}

  void make_room(Eigen::Index num_vertices);
  void begin(const Eigen::Matrix3Xd& x);
  // Adds positions `x` (3 x V, m), `dt` (s) after the last ones. Returns true if the window is complete; then call
  // expected_motion() and begin().
  bool add(const Eigen::Matrix3Xd& x, double dt);
  // Estimates how far any vertex may get from its last place within `horizon` (s), m. This is as far as it has been
  // from there in the window, plus its drift: the motion of its mean position at the present rate. If `slows` is true,
  // a drift that became slower during the window is taken to slow down further at that rate.
  [[nodiscard]] double expected_motion(double horizon, bool slows) const;
  // Returns true if no vertex was farther than `extent` (m) from its last place in the window, and no mean position
  // moved faster than `drift` (m/s).
  [[nodiscard]] bool stays_within(double extent, double drift) const;
  [[nodiscard]] double length() const { return length_; }

 private:
  friend struct Fields<MotionWindow>;
  // Returns how far (m) vertex v has been from its last place in the window.
  [[nodiscard]] double extent_at(Eigen::Index v) const;
  // Returns the mean position of vertex v in a third of the window, minus its first one, m.
  [[nodiscard]] Eigen::Vector3d mean_at(Eigen::Index v, std::size_t third) const;

  double length_;
  double time_ = 0.0;                     // s, since begin()
  Eigen::Index num_vertices_ = 0;         // number of vertices; the arrays may have room for more
  Eigen::Matrix3Xd start_;                // m, positions at begin()
  std::array<int, 3> num_ticks_{};        // ticks in each third
  std::array<Eigen::Matrix3Xd, 3> sums_;  // m, sum over the ticks of each third of positions minus start_
  Eigen::Matrix3Xd last_, low_, high_;    // m, minus start_: the last positions, and least and greatest coordinates in
                                          // the window
};

// Damps a sheet that nothing disturbs any more, and detects when it is at rest.
//
// Real cloth in air stops swinging within seconds, by losses that the Rayleigh damping of a material hardly has at low
// frequencies. So a calm sheet is damped a little: its velocities decay at up to kDampingRate * sqrt(g / size), the
// rate of a pendulum of its size. A sheet is calm if nothing has disturbed it for kCalmAfter seconds and its kinetic
// energy is low. The mean energy over about a second must be below the energy that lifts the sheet by kCalmHeight times
// its size. Other sheets are not damped.
//
// A sheet is at rest if no vertex is expected to move by more than kTolerance within kHorizon. Either of two windows
// can show that: the short one for sheets that soon come to a stop, the long one for sheets that tremble. If a damped
// sheet slows down in two successive windows of one length, it is taken to slow down further; such windows must last
// about a swing or longer. Speeds are a poorer measure: a vertex held by a body has some within each substep, but stays
// in place.
//
// A sheet that touches itself is pushed a little in each phase of contact, and so trembles or creeps where cloth would
// lie still. It counts as calm with kTouchingEnergy times as much energy. It is at rest if it stays in place and
// creeps by less than kTouchingDrift in a window.
class RestWatch {
 public:
  static constexpr double kCalmAfter = 5.0;        // s, time without disturbance after which a sheet may be calm
  static constexpr double kCalmHeight = 4.0e-5;    // -, lift over the size; a calm sheet has less kinetic energy
  static constexpr double kDampingRate = 0.8;      // -, largest decay rate of velocities over sqrt(g / size)
  static constexpr double kShortWindow = 2.0;      // s, length of the short MotionWindow
  static constexpr double kLongWindow = 8.0;       // s, length of the long MotionWindow
  static constexpr double kHorizon = 60.0;         // s, time for which the motion is predicted
  static constexpr double kSwing = 6.0;            // -, least length of a window over sqrt(size / g), to tell slowing
                                                   // down from swinging
  static constexpr double kTolerance = 9.0e-5;     // m, largest expected motion of a sheet at rest
  static constexpr double kTouchingEnergy = 4.0;   // -
  static constexpr double kTouchingExtent = 2e-3;  // m, how far from its place a vertex may be
  static constexpr double kTouchingDrift = 1e-4;   // m/s

  struct Tick {
    double gravity = 0.0;  // m/s^2, >= 0
    double dt = 0.0;       // s
    bool damps = true;     // true if the sheet may be damped
    bool touches = false;  // true if it touches itself
  };

  // `size`: larger side of the sheet as built, m.
  explicit RestWatch(double size) : size_(size) {}

  // Allocates the memory that after_tick() needs.
  void make_room(Eigen::Index num_vertices);
  // Must be called when something other than its own motion has changed the sheet, or may change it: the wait for calm
  // begins again.
  void disturb();
  // Must be called after each tick, with its result `state`. Damps the velocities if the sheet is calm.
  void after_tick(const fem::Model& model, const Tick& tick, fem::State& state);

  // Returns true if the sheet is calm, as explained above, and is damped.
  [[nodiscard]] bool is_calm() const { return is_calm_; }
  [[nodiscard]] bool is_at_rest() const { return is_at_rest_; }

 private:
  friend struct Fields<RestWatch>;
  double size_;
  double calm_time_ = 0.0;  // s, simulated time since the last disturb()
  double energy_ = 0.0;     // J, mean kinetic energy over about a second
  double touched_ = 0.0;    // -, share of the ticks over about a second in which the sheet touched itself
  bool is_calm_ = false;
  bool is_measuring_ = false;
  bool is_at_rest_ = false;
  std::array<MotionWindow, 2> windows_{MotionWindow(kShortWindow), MotionWindow(kLongWindow)};
  std::array<bool, 2> settles_{};  // by window: true if the last one predicted rest under the assumption that slowing
                                   // down continues
};

}  // namespace kerf::sheet
