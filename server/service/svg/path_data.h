#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/core/cut/curve.h"

namespace kerf::svg {

struct PathData {
  std::vector<cut::Subpath> subpaths;  // In the units and the frame of the text; each has at least one segment.
  std::string error;                   // Names the fault and its byte; empty if everything was parsed.
};

// Parses the `d` attribute of a path element: M L H V C S Q T A Z, relative and absolute, also repeated without their
// letter. Numbers have SVG's syntax ("1.5.5" is 1.5 and 0.5; flags of arcs need no separator). Parsing ends at the
// first error or after `max_segments` segments, and the part before that is returned (SVG 1.1, appendix F.2).
PathData parse_path_data(std::string_view text, std::size_t max_segments);

}  // namespace kerf::svg
