#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/core/cut/curve.h"

namespace kerf::svg {

struct PathData {
  std::vector<cut::Subpath> subpaths;  // in the units and the frame of the text; those of at least one segment
  std::string error;                   // what is wrong and at which byte; empty where all was read
};

// The `d` of a path element: M L H V C S Q T A Z, relative and absolute, repeated without their letter, in the number
// syntax of SVG ("1.5.5" is 1.5 and 0.5, flags of arcs need no separator). Reading ends at the first error, or after
// `max_segments` segments, and what came before counts (SVG 1.1, appendix F.2).
PathData parse_path_data(std::string_view text, std::size_t max_segments);

}  // namespace kerf::svg
