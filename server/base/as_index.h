#pragma once

#include <cstddef>

namespace kerf {

// Of a vertex, row or column, never negative, for containers.
inline std::size_t as_index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace kerf
