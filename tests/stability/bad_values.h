#pragma once

#include <array>
#include <limits>

namespace kerf::stability {

inline constexpr std::array<double, 6> kBadValues{std::numeric_limits<double>::quiet_NaN(),
                                                  std::numeric_limits<double>::infinity(),
                                                  -std::numeric_limits<double>::infinity(),
                                                  1e300,
                                                  -1e300,
                                                  std::numeric_limits<double>::denorm_min()};

}  // namespace kerf::stability
