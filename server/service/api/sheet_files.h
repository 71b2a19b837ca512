#pragma once

#include <string>

#include "kerf/v1/sheets.pb.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/snapshot.h"

// A whole sheet as bytes for other programs.
namespace kerf::api {

// All of SheetState but the name.
v1::SheetState encode_exact_state(const sheet::Sheet& sheet);

// Wavefront OBJ: a `v` (world, m) and a `vt` (material coordinates, m) for each vertex that a triangle uses, in the
// order of their ids, then an `f` for each triangle with material in the order of the slots. Numbers read back to the
// same double.
std::string encode_obj(const sheet::Snapshot& snapshot);

}  // namespace kerf::api
