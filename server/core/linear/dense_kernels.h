#pragma once

#include <cstddef>

// Dense parts of a sparse Cholesky factorisation in vector code, chosen for the processor at run time; T is float or
// double. The same bits on every processor: each entry is a sum of its own in one order, sums over rows go in
// kBlockLanes partial ones, nothing is contracted.
namespace kerf::fem {

// A panel: the first columns of a lower triangle, column after column, `stride` entries apart, a multiple of
// kBlockLanes; column 0 begins at a multiple of 64 bytes. What stands above the diagonal and beyond the last row has no
// meaning and may be changed, and kBlockLanes entries behind the last column may be read.
template <typename T>
struct PanelView {
  T* entries = nullptr;
  std::size_t stride = 0;
  std::size_t rows = 0;
  std::size_t width = 0;  // columns, <= rows, a multiple of 3
};

// The least pivot, relative to the entry of the matrix on the diagonal before anything was subtracted from it.
template <typename T>
struct PivotRule {
  T least = 0;               // -
  bool replaces = false;     // smaller ones by that entry or their own size; else they end the factorisation
  std::size_t replaced = 0;  // so far
};

// The panel of a symmetric matrix becomes that of its Cholesky factor. `diagonal`: `width` entries, see PivotRule.
// False: a pivot was too small or not a number; the panel then holds anything.
template <typename T>
bool factor_panel(const PanelView<T>& panel, const T* diagonal, PivotRule<T>& rule);

// The lower triangle of `update`, (rows - width)^2, a panel of as many columns, -= L21 L21^T, L21 being what of the
// factored panel is below its first `width` rows.
template <typename T>
void subtract_outer_product(const PanelView<T>& panel, const PanelView<T>& update);

// w: `rows` entries, room for kBlockLanes more. Forward: the first `width` become y = L11^-1 w1, the others are w2 -
// L21 y. Backward: the first become L11^-T (w1 - L21^T w2).
template <typename T>
void substitute_forward(const PanelView<const T>& panel, T* w);
template <typename T>
void substitute_backward(const PanelView<const T>& panel, T* w);

}  // namespace kerf::fem
