#pragma once

#include <string_view>

#include "server/base/result.h"
#include "server/core/mesh/build/mesh_file.h"
#include "server/core/mesh/build/sheet_assembly.h"

namespace kerf::mesh {

inline constexpr std::size_t kMaxPlyHeaderLines = 1000;  // besides comments
inline constexpr std::size_t kMaxPlyHeaderLineBytes = 4096;

// Reads a PLY file (Turk, "The PLY Polygon File Format", 1994), ascii, binary_little_endian or binary_big_endian, lines
// ended by LF, CR LF or CR. From element "vertex" it takes x, y, z of any type. From element "face" it takes the list
// vertex_indices or vertex_index of an integer type. Element "tristrips" has strips of triangles in such a list; -1
// begins another strip. Other elements and properties, lists too, are skipped. s and t, u and v, or texture_u and
// texture_v of vertices are texture coordinates. Elements may come in any order; in ascii files each row is one line,
// and blank lines are skipped. Errors name the line of the header or text in message and field ("ply:17"), in binary
// files the element ("ply:vertex[3]", from 0). Those of single faces are collected, up to kMaxShownFaults:
//   PLY_TOO_LARGE, PLY_HEADER (the header is incomplete, malformed or beyond its two limits above), PLY_TRUNCATED (the
//   file ends within an element), PLY_TRAILING (more follows after the last one), PLY_VALUES (a line has more or fewer
//   values than the header says, or the length of a list is not a whole number), PLY_NUMBER, PLY_INDEX, PLY_FACE,
//   PLY_EMPTY.
// `faults`: gets the list, if that is the error.
Result<MeshFile> read_ply(std::string_view file, FaultList* faults = nullptr);

// Reads a PLY file and makes a sheet of it. Errors: those of read_ply() and assemble().
Result<ImportedSheet> parse_ply(std::string_view file, const MeshReading& reading = {});

}  // namespace kerf::mesh
