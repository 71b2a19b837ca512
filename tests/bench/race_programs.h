#pragma once

#include <string>
#include <string_view>

namespace kerf::bench {

// Prints the race of all programs and settings whose name contains `only`, on a grid of side x side vertices. Whether
// Kerf's sheets of the explicit integrator are stretched at rest as they should be.
bool compare_programs(const std::string& mesh, int side, std::string_view only);

}  // namespace kerf::bench
