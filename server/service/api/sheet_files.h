#pragma once

#include <string>

#include "kerf/v1/sheets.pb.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/snapshot.h"

// Encodes a whole sheet for other programs.
namespace kerf::api {

// Encodes all of SheetState except the name. `with_topology`: false leaves out the arrays that depend on it alone.
v1::SheetState encode_exact_state(const sheet::Sheet& sheet, bool with_topology = true);

// Encodes a Wavefront OBJ file. A `v` (world, m) and a `vt` (material coordinates, m) stand for each vertex used by a
// triangle, in the order of ids. An `f` follows for each triangle with material, in the order of slots. Numbers read
// back to the same double.
std::string encode_obj(const sheet::Snapshot& snapshot);

}  // namespace kerf::api
