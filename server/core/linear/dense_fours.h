#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace kerf::fem {

// A small dense matrix, by columns, each in fours of rows; rows beyond the last hold 0.
template <typename T>
struct DenseFours {
  std::size_t size = 0;
  std::vector<std::array<T, 4>> entries;

  void resize(std::size_t n) {
    size = n;
    entries.assign(n * num_fours(), {});
  }
  [[nodiscard]] std::size_t num_fours() const { return (size + 3) / 4; }  // of a column
  T& at(std::size_t row, std::size_t column) { return entries[column * num_fours() + row / 4][row % 4]; }
};

// Sets `to` to the matrix times `from`, four right-hand sides side by side, in vector code chosen for the processor at
// run time: each entry is a sum in the order of columns, nothing is contracted. `to` has room for 4 x 4 x num_fours().
template <typename T>
void multiply(const DenseFours<T>& matrix, const T* from, T* to);

}  // namespace kerf::fem
