#pragma once

#include "server/core/fem/element/material.h"

namespace kerf::bench {

// The tables of tests/bench/README.md "After a cut": the system of a falling sheet, side x side vertices, right after
// 20 kirigami slits, for steps of 1/60 and 1/240 s, solved anew and with factors from before the cut. Prints them.
// False: a solver that converged is not where the direct one is.
bool measure_after_cut(const char* name, const fem::Material& material, int side);

}  // namespace kerf::bench
