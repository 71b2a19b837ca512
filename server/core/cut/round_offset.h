#pragma once

#include <polyclipping/clipper.hpp>

namespace kerf::cut {

// Makes the outlines of strips around chains of chords, with round joins and ends. Clipper's own ClipperOffset makes
// the same points, but takes sine, cosine and angles from the C library, see elementary.h. Clipper only unites here,
// which takes correctly rounded operations.
class RoundOffset {
 public:
  // `radius`: half the width of the strip; `arc_tolerance`: largest distance of an arc from its chords; both in grid
  // units and above 0.
  RoundOffset(double radius, double arc_tolerance);

  // Adds a chain of at least 2 points, each different from the next; a closed one has at least 3, and does not repeat
  // the first.
  void add(const ClipperLib::Path& chain, bool is_closed);
  // Returns the outline of the union of all strips: outer loops counter-clockwise, holes clockwise.
  [[nodiscard]] ClipperLib::Paths united() const;

 private:
  // A closed loop of points is followed on its right side.
  void follow(const ClipperLib::Path& loop, std::size_t first);

  double radius_;         // grid units
  double sine_, cosine_;  // of the angle of a chord
  double chords_a_radian_;
  ClipperLib::Paths sides_;  // they cross each other and themselves
};

}  // namespace kerf::cut
