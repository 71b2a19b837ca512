#pragma once

#include "server/core/fem/element/material.h"

namespace kerf::bench {

// Prints the tables of tests/bench/notes/after-a-cut.md. The system is that of a falling sheet, side x side
// vertices, right after 20 kirigami slits, for steps of 1/60 and 1/240 s. It is solved from scratch and with factors
// from before the cut. Returns false if a converged solver disagrees with the direct one.
bool measure_after_cut(const char* name, const fem::Material& material, int side);

}  // namespace kerf::bench
