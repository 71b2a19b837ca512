#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/service/drawing/drawing.h"

// Reads SVG drawings: SVG 1.1 with the relaxations of SVG 2, and the style sheets in them.
namespace kerf::svg {

inline constexpr std::size_t kMaxTextBytes = std::size_t{512} << 10;  // Without embedded pictures and fonts.
inline constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20;   // With them, and decompressed.
inline constexpr int kMaxElements = 50'000;         // Elements visited; those repeated by `use` count each time.
inline constexpr int kMaxDepth = 64;                // Nesting of elements, those reached through `use` included.
inline constexpr std::size_t kMaxGroups = 200'000;  // Layers, classes and ids of elements visited.
// Attribute bytes visited; those repeated by `use` count each time.
inline constexpr std::size_t kMaxAttributeBytes = std::size_t{8} << 20;

struct ReadOptions {
  double unit = 0.0;   // m of a unit of the drawing's coordinates; 0: a CSS pixel is 0.0254 / 96 m.
  bool dashes = true;  // Dashed strokes become dashes.
};

// Returns the text of a drawing in UTF-8: decompressed, and without embedded pictures and fonts. Errors, field
// "cut.curve.svg": kInvalidArgument SVG_TOO_LARGE, SVG_MALFORMED.
Result<std::string> outline_text(std::string_view data);

// Reads a drawing from the text or the bytes of its file, see text_of(), also compressed by gzip. y points up: the
// picture stands upright, and the upper left corner of the first viewport is the origin. Shapes that paint nothing are
// there, and marked. Faulty path data counts up to its error, as SVG demands, and is reported. Nothing outside the text
// is read, and only XML's five predefined entities are expanded.
//
// Errors, field "cut.curve.svg": kInvalidArgument SVG_TOO_LARGE, SVG_MALFORMED (not XML, or not SVG);
// kResourceExhausted SVG_TOO_COMPLEX (kMaxElements, kMaxDepth, kMaxGroups, kMaxAttributeBytes, kMaxCssSelectors,
// kMaxCssSteps, drawing::kMaxSegments).
Result<drawing::Drawing> read(std::string_view data, const ReadOptions& options = {});

}  // namespace kerf::svg
