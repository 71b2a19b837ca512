#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace kerf::linear {

// A small dense matrix stored by columns, each in groups of four rows. Rows beyond the last hold 0.
template <typename T>
struct DenseFours {
  std::size_t size = 0;
  std::vector<std::array<T, 4>> entries;

  void resize(std::size_t n) {
    size = n;
    entries.assign(n * num_fours(), {});
  }
  [[nodiscard]] std::size_t num_fours() const { return (size + 3) / 4; }  // per column
  T& at(std::size_t row, std::size_t column) { return entries[column * num_fours() + row / 4][row % 4]; }
};

// Sets `to` to the matrix times `from`, for four right-hand sides, in vector code chosen at run time. Both arrays hold
// the four numbers of each row side by side. Each entry is a sum in the order of columns, without fused multiply-add.
// `to` has room for 16 num_fours() numbers.
template <typename T>
void multiply(const DenseFours<T>& matrix, const T* from, T* to);

}  // namespace kerf::linear
