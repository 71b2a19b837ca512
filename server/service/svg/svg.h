#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"
#include "server/core/cut/curve.h"

// Turns SVG drawings into cut lines: SVG 1.1 with the relaxations of SVG 2. The outline of every shape is cut,
// regardless of its paint.
namespace kerf::svg {

inline constexpr std::size_t kMaxTextBytes = std::size_t{512} << 10;
inline constexpr int kMaxElements = 50'000;  // Elements visited; those repeated by `use` count each time.
inline constexpr int kMaxDepth = 64;         // Nesting of elements, those reached through `use` included.
// Attribute bytes visited; those repeated by `use` count each time.
inline constexpr std::size_t kMaxAttributeBytes = std::size_t{8} << 20;

struct Drawing {
  // The path in m, with a CSS pixel of 0.0254 / 96 m. y points up: the picture stands upright, and the upper left
  // corner of the first viewport is the origin. Valid.
  cut::Path path;
  // Lists the parts of the drawing that are not in the path, by kind with counts, as text for users.
  std::vector<std::string> not_cut;
};

// Reads a drawing. Faulty path data counts up to its error, as SVG demands, and is reported. Nothing outside the text
// is read, and only XML's five predefined entities are expanded.
//
// Errors, field "cut.curve.svg": kInvalidArgument SVG_TOO_LARGE, SVG_MALFORMED (not XML, or not SVG), SVG_EMPTY (no
// outline in it), those of cut::validate() (CURVE_TOO_LONG: more than cut::kMaxPathSegments segments);
// kResourceExhausted SVG_TOO_COMPLEX (kMaxElements, kMaxDepth, kMaxAttributeBytes).
Result<Drawing> read(std::string_view text);

}  // namespace kerf::svg
