#pragma once

#include "server/core/cut/curve.h"
#include "server/core/cut/rational_piece.h"

namespace kerf::cut {

// flatten() of the alternatives that are made of rational pieces. Chords are halved where they are farthest from their
// piece, so that long flat stretches take few and tight bends take many; cusps become points first.
FlatCurve flatten_ellipse(const Ellipse& ellipse, double tolerance);
FlatCurve flatten_path(const Path& path, double tolerance);

// Every piece of a subpath in order, the closing line included; `rounding_m`: bound on what arcs lose by rounding.
struct SubpathPieces {
  std::vector<RationalPiece> pieces;
  double rounding_m = 0.0;
};
SubpathPieces pieces_of(const Subpath& subpath);
SubpathPieces pieces_of(const Ellipse& ellipse);

}  // namespace kerf::cut
