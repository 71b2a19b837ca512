#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"
#include "server/core/cut/curve.h"

// Drawings as cut lines: SVG 1.1 with what SVG 2 made looser. The outline of every shape is one, whatever its paint.
namespace kerf::svg {

inline constexpr std::size_t kMaxTextBytes = std::size_t{512} << 10;
inline constexpr int kMaxElements = 50'000;  // looked at, those that `use` repeats each time they are
inline constexpr int kMaxDepth = 64;         // of elements in one another, those reached through `use` included
inline constexpr std::size_t kMaxAttributeBytes = std::size_t{8} << 20;  // looked at, those that `use` repeats likewise

struct Drawing {
  // m, a CSS pixel being 0.0254 / 96 m; y up, so that the picture stands upright with the first viewport's upper left
  // corner at the origin. Valid.
  cut::Path path;
  // What of the drawing is not in the path, for people: by kind, with counts.
  std::vector<std::string> not_cut;
};

// Path data with an error is drawn up to it, as SVG has it, and reported. Nothing outside the text is looked at;
// entities other than XML's own five are not expanded.
// Errors, field "cut.curve.svg": kInvalidArgument SVG_TOO_LARGE, SVG_MALFORMED (not XML, or not SVG), SVG_EMPTY (no
// outline in it), those of cut::validate() (CURVE_TOO_LONG: more than cut::kMaxPathSegments segments);
// kResourceExhausted SVG_TOO_COMPLEX (kMaxElements, kMaxDepth, kMaxAttributeBytes).
Result<Drawing> read(std::string_view text);

}  // namespace kerf::svg
