#pragma once

#include <algorithm>
#include <vector>

namespace kerf {

// Sorts the values in ascending order and removes duplicates.
template <typename T>
void sort_unique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace kerf
