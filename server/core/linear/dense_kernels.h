#pragma once

#include <cstddef>

// Dense kernels of a sparse Cholesky factorisation in vector code chosen for the processor at run time; T is float or
// double. Results have the same bits on every processor. Each entry is a sum of its own in one order, sums over rows
// use kBlockLanes partial sums, and no multiply-add is fused.
namespace kerf::linear {

// A panel: the first columns of a lower triangle, stored by columns that are `stride` entries apart. `stride` is a
// multiple of kBlockLanes; column 0 begins at a multiple of 64 bytes. Entries above the diagonal and beyond the last
// row have no meaning and may be changed. kBlockLanes entries behind the last column may be read.
template <typename T>
struct PanelView {
  T* entries = nullptr;
  std::size_t stride = 0;
  std::size_t rows = 0;
  std::size_t width = 0;  // columns, <= rows, a multiple of 3
};

// Rule for small pivots. Pivots are measured relative to the diagonal entry of the matrix before any subtraction.
template <typename T>
struct PivotRule {
  T least = 0;  // -, least accepted relative pivot
  // Replaces smaller pivots instead of failing, by the larger of the diagonal entry and the pivot's magnitude. Diagonal
  // entries must be positive and pivots finite.
  bool replaces = false;
  std::size_t replaced = 0;  // number of pivots replaced so far
};

// Replaces a panel of a symmetric matrix by the same panel of its Cholesky factor. `diagonal` holds the `width`
// diagonal entries of the original matrix that PivotRule measures pivots by. Returns false if a pivot was too small or
// not a number; the panel then holds arbitrary values.
template <typename T>
bool factor_panel(const PanelView<T>& panel, const T* diagonal, PivotRule<T>& rule);

// Subtracts L21 L21^T from the lower triangle of `update`, a panel of rows - width rows and columns. L21 is the part of
// the factored panel below its first `width` rows.
template <typename T>
void subtract_outer_product(const PanelView<T>& panel, const PanelView<T>& update);

// Substitutes in place in w, which has `rows` entries and room for kBlockLanes more. L11 is the triangle in the first
// `width` rows of the panel, L21 the part below; w1 and w2 are the same parts of w. Forward: w1 becomes y = L11^-1 w1,
// and w2 becomes w2 - L21 y. Backward: w1 becomes L11^-T (w1 - L21^T w2).
template <typename T>
void substitute_forward(const PanelView<const T>& panel, T* w);
template <typename T>
void substitute_backward(const PanelView<const T>& panel, T* w);

}  // namespace kerf::linear
