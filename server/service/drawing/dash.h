#pragma once

#include <vector>

#include "server/core/cut/curve.h"

namespace kerf::drawing {

// A pattern of lengths drawn and left out in turn, in the units of the line.
struct Dashes {
  std::vector<double> lengths;  // Each >= 0, not all 0; an odd number counts twice.
  double offset = 0.0;          // Place in the pattern where each line begins.
};

double total_length(const Dashes& dashes);

// Returns the dashes of a line as parts of its segments, each exact. Their ends are kept (see keep_ends()), other than
// those of the line itself. Dashes of no length are left out. A closed line begins and ends as if it were open; if both
// its ends are drawn they meet. The line must have no arcs. Stops after `most` steps of
// the pattern and segments together.
std::vector<cut::Subpath> dashed(const cut::Subpath& line, const Dashes& dashes, std::size_t most);

}  // namespace kerf::drawing
