#pragma once

#include "server/core/cut/curve.h"
#include "server/core/cut/rational_piece.h"

namespace kerf::cut {

// Flatten the alternatives of Curve that consist of rational pieces; see flatten(). They halve the chord farthest from
// its piece, again and again. So long flat stretches take few chords and tight bends take many. Cusps become points
// first.
FlatCurve flatten_ellipse(const Ellipse& ellipse, double tolerance);
FlatCurve flatten_path(const Path& path, double tolerance);

// All pieces of a subpath in order, including the closing line. `rounding_m`: bound on the rounding error of arcs, m.
struct SubpathPieces {
  std::vector<RationalPiece> pieces;
  double rounding_m = 0.0;
};
SubpathPieces pieces_of(const Subpath& subpath);
SubpathPieces pieces_of(const Ellipse& ellipse);

}  // namespace kerf::cut
