#pragma once

#include "server/core/cut/curve.h"

namespace kerf::drawing {

// Leads lines of a drawing that together surround something into one closed line each, as programs for drawing write
// four lines for a frame. Ends meet if they are closest to each other, and at most kClosingShare of the drawing's size
// apart; the later line then begins where the earlier one ends. Lines that are there twice are left out once. Closed
// lines stay as they are, and so do those that surround nothing. The path must have no arcs.
void close_lines(cut::Path& path);

// Largest distance of ends that meet, over the drawing's larger side: that of cuts.  -
inline constexpr double kClosingShare = 1e-3;

}  // namespace kerf::drawing
