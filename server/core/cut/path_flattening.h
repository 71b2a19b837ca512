#pragma once

#include "server/core/cut/curve.h"
#include "server/core/cut/rational_piece.h"

namespace kerf::cut {

// Flattens the alternatives of a Curve that are made of rational pieces; see flatten(). Chords are halved where they
// are farthest from their piece, so that long flat stretches take few and tight bends take many; cusps become points
// first.
FlatCurve flatten_ellipse(const Ellipse& ellipse, double tolerance);
FlatCurve flatten_path(const Path& path, double tolerance);

// Returns every piece of a subpath in order, the closing line included. `rounding_m`: bound on the rounding error of
// arcs.
struct SubpathPieces {
  std::vector<RationalPiece> pieces;
  double rounding_m = 0.0;
};
SubpathPieces pieces_of(const Subpath& subpath);
SubpathPieces pieces_of(const Ellipse& ellipse);

}  // namespace kerf::cut
