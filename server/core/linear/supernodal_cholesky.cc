#include "server/core/linear/supernodal_cholesky.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "server/base/as_index.h"
#include "server/base/interruption.h"

namespace kerf::linear {
namespace {

// Column stride of a panel, in units of Lanes16.
std::size_t stride_of(std::size_t rows) {
  return (rows + kBlockLanes - 1) / kBlockLanes;
}

}  // namespace

template <typename T>
PanelView<T> SupernodalCholesky<T>::view(Storage& storage, const std::vector<std::size_t>& begin, int s,
                                         std::size_t width) {
  return {storage[begin[as_index(s)]].lane.data(), kBlockLanes * stride_of(rows(s)), rows(s), width};
}

template <typename T>
void SupernodalCholesky<T>::analyse(const BlockMatrix& A) {
  auto supernodes = std::make_shared<Supernodes>();
  supernodes->analyse(A);
  analyse(A, std::move(supernodes));
}

template <typename T>
void SupernodalCholesky<T>::analyse(const BlockMatrix& A, std::shared_ptr<const Supernodes> supernodes) {
  supernodes_ = std::move(supernodes);
  const int size = supernodes_->size();
  panel_begin_.resize(as_index(size));
  update_begin_.resize(as_index(size));
  std::size_t panels = 0;
  std::size_t top = 0;  // top of the stack
  std::size_t highest = 0;
  std::size_t longest = 0;
  std::size_t widest = 0;
  factor_flops_ = 0.0;
  num_entries_ = 0;
  for (int s = 0; s < size; ++s) {
    panel_begin_[as_index(s)] = panels;
    panels += width(s) * stride_of(rows(s));
    const std::span<const int> children = supernodes_->children(s);
    if (!children.empty()) top = update_begin_[as_index(children.front())];
    update_begin_[as_index(s)] = top;
    const std::size_t below = rows(s) - width(s);
    top += below * stride_of(below);
    highest = std::max(highest, top);
    longest = std::max(longest, rows(s));
    widest = std::max(widest, below * stride_of(below));
    for (std::size_t j = 0; j < width(s); ++j) {
      const auto column = static_cast<double>(rows(s) - j);
      factor_flops_ += column * column;
      num_entries_ += rows(s) - j;
    }
  }
  scratch_begin_ = highest;
  num_panels_ = panels + 1;
  num_updates_ = highest + widest + 1;
  panels_.clear();
  panels_.reserve(num_panels_);
  updates_.clear();
  updates_.reserve(num_updates_);
  front_.assign(stride_of(longest) + 1, {});
  diagonal_.assign(3 * as_index(A.num_rows()), T{0});
  work_.assign(3 * as_index(A.num_rows()), T{0});
  place_.assign(as_index(A.num_rows()), 0);
}

template <typename T>
void SupernodalCholesky<T>::assemble(const BlockMatrix& A, std::span<const Eigen::Matrix3d> frames, int s) {
  const std::span<const int> rows = supernodes_->rows(s);
  for (std::size_t i = 0; i < rows.size(); ++i) place_[as_index(rows[i])] = static_cast<int>(i);
  const PanelView<T> to = panel(s);
  for (int j = 0; j < supernodes_->width(s); ++j) {
    const int new_column = supernodes_->first(s) + j;
    const int column = supernodes_->old_from_new(new_column);
    for (int at = A.row_begin(column); at < A.row_end(column); ++at) {
      const int row = A.column(at);
      if (supernodes_->new_from_old(row) < new_column) continue;
      // A is symmetric: this is block (row, column).
      Eigen::Matrix3d block = A.block(at).transpose();
      if (!frames.empty()) block = frames[as_index(row)].transpose() * block * frames[as_index(column)];
      T* const entry =
          to.entries + 3 * as_index(place_[as_index(supernodes_->new_from_old(row))]) + 3 * as_index(j) * to.stride;
      for (std::size_t b = 0; b < 3; ++b) {
        for (std::size_t a = 0; a < 3; ++a) {
          entry[a + b * to.stride] = static_cast<T>(block(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
        }
      }
      if (row != column) continue;
      for (std::size_t a = 0; a < 3; ++a) diagonal_[3 * as_index(new_column) + a] = entry[a + a * to.stride];
    }
  }
}

template <typename T>
void SupernodalCholesky<T>::extend_add(int c, int s) {
  const std::span<const int> places = supernodes_->rows_in_parent(c);
  const std::size_t from_rows = 3 * places.size();
  const std::size_t from_stride = kBlockLanes * stride_of(from_rows);
  const T* from = updates_[update_begin_[as_index(c)]].lane.data();
  const PanelView<T> own = panel(s);
  const std::size_t below = rows(s) - width(s);
  const std::size_t update_stride = kBlockLanes * stride_of(below);
  T* const update = updates_[scratch_begin_].lane.data();
  for (std::size_t j = 0; j < places.size(); ++j) {
    for (std::size_t b = 0; b < 3; ++b, from += from_stride) {
      const std::size_t column = 3 * as_index(places[j]) + b;
      const bool is_own = column < own.width;
      const std::size_t first_row = is_own ? 0 : own.width;
      T* const to = is_own ? own.entries + column * own.stride : update + (column - own.width) * update_stride;
      for (std::size_t i = j; i < places.size(); ++i) {
        T* const entry = to + (3 * as_index(places[i]) - first_row);
        entry[0] += from[3 * i];
        entry[1] += from[3 * i + 1];
        entry[2] += from[3 * i + 2];
      }
    }
  }
}

template <typename T>
bool SupernodalCholesky<T>::factorise(const BlockMatrix& A, std::span<const Eigen::Matrix3d> frames,
                                      PivotRule<T>& rule) {
  panels_.assign(num_panels_, Lanes16<T>{});
  updates_.resize(num_updates_);
  for (int s = 0; s < supernodes_->size(); ++s) {
    interruption_point();
    if (stop_.is_met()) return false;
    assemble(A, frames, s);
    const PanelView<T> own = panel(s);
    const std::size_t below = own.rows - own.width;
    const std::size_t update_size = below * stride_of(below);
    const auto scratch = updates_.begin() + static_cast<std::ptrdiff_t>(scratch_begin_);
    std::fill(scratch, scratch + static_cast<std::ptrdiff_t>(update_size), Lanes16<T>{});
    for (const int c : supernodes_->children(s)) extend_add(c, s);
    if (!factor_panel(own, diagonal_.data() + 3 * as_index(supernodes_->first(s)), rule)) return false;
    if (below == 0) continue;
    subtract_outer_product(own, {scratch->lane.data(), kBlockLanes * stride_of(below), below, below});
    std::copy(scratch, scratch + static_cast<std::ptrdiff_t>(update_size),
              updates_.begin() + static_cast<std::ptrdiff_t>(update_begin_[as_index(s)]));
  }
  return true;
}

template <typename T>
void SupernodalCholesky<T>::solve(const VertexField& b, VertexField& x) {
  const int n = supernodes_->num_vertices();
  for (int i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      work_[3 * as_index(i) + c] = static_cast<T>(b(static_cast<Eigen::Index>(c), supernodes_->old_from_new(i)));
    }
  }
  T* const w = front_.front().lane.data();
  const auto front_of = [&](int s) {
    const PanelView<T> own = panel(s);
    return PanelView<const T>{own.entries, own.stride, own.rows, own.width};
  };
  for (int s = 0; s < supernodes_->size(); ++s) {
    const PanelView<const T> own = front_of(s);
    T* const columns = work_.data() + 3 * as_index(supernodes_->first(s));
    std::copy(columns, columns + own.width, w);
    std::fill(w + own.width, w + own.rows, T{0});
    substitute_forward(own, w);
    std::copy(w, w + own.width, columns);
    const std::span<const int> vertices = supernodes_->rows(s);
    for (std::size_t i = own.width / 3; i < vertices.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) work_[3 * as_index(vertices[i]) + c] += w[3 * i + c];
    }
  }
  for (int s = supernodes_->size(); s-- > 0;) {
    const PanelView<const T> own = front_of(s);
    const std::span<const int> vertices = supernodes_->rows(s);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) w[3 * i + c] = work_[3 * as_index(vertices[i]) + c];
    }
    substitute_backward(own, w);
    std::copy(w, w + own.width, work_.data() + 3 * as_index(supernodes_->first(s)));
  }
  for (int i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      x(static_cast<Eigen::Index>(c), supernodes_->old_from_new(i)) = static_cast<double>(work_[3 * as_index(i) + c]);
    }
  }
}

template class SupernodalCholesky<float>;
template class SupernodalCholesky<double>;

}  // namespace kerf::linear
