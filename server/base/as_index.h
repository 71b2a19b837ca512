#pragma once

#include <cstddef>

namespace kerf {

// Converts the number of a vertex, row or column (>= 0) to a container index.
inline std::size_t as_index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace kerf
