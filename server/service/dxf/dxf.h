#pragma once

#include <cstddef>
#include <string_view>

#include "server/base/result.h"
#include "server/service/drawing/drawing.h"

// Reads DXF drawings as text, of release 12 or later.
namespace kerf::dxf {

inline constexpr std::size_t kMaxFileBytes = std::size_t{4} << 20;
inline constexpr int kMaxEntities = 100'000;  // Entities visited; those of blocks count at each insertion.
inline constexpr int kMaxDepth = 16;          // Nesting of blocks.

// True if the bytes are a DXF drawing, also a binary one or compressed by gzip, rather than SVG.
bool is_dxf(std::string_view data);

// Reads a file's text, also compressed by gzip: lines, polylines, arcs, circles, ellipses, splines and inserted blocks
// of the model, in the plane. Layers that are frozen or off, and invisible entities, are there and marked. `unit`: m of
// a unit, which replaces that of the file; 0: $INSUNITS, else inches if $MEASUREMENT is 0, else millimetres. Splines of
// a degree above 3 are followed to a millionth of their size. All else is reported.
//
// Errors, field "cut.curve.dxf": kInvalidArgument DXF_TOO_LARGE, DXF_MALFORMED (the message names the line),
// DXF_BINARY; kResourceExhausted DXF_TOO_COMPLEX (kMaxEntities, kMaxDepth, drawing::kMaxSegments).
Result<drawing::Drawing> read(std::string_view data, double unit = 0.0);

}  // namespace kerf::dxf
