#include "server/core/fem/model/inertia_cluster.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace kerf::fem {

using mesh::VertexId;

InertiaCluster::InertiaCluster(const Model& model, std::span<const VertexId> members, std::span<const StiffPart> parts,
                               const AddedInertia& added)
    : lowest_(members.front()), parts_(parts.begin(), parts.end()) {
  std::vector<Entry> entries = sum_of(model, members, parts, added);
  set_order(members, entries);
  set_matrix(model, entries);
  set_pattern();
  is_piece_ = has_whole_elements(model, members);
  held_.assign(vertices_.size(), 0);
  factor(0, 0b111);
  if (is_dense()) invert();
}

// Entries of the same place are added in the order of the parts.
std::vector<InertiaCluster::Entry> InertiaCluster::sum_of(const Model& model, std::span<const VertexId> members,
                                                          std::span<const StiffPart> parts, const AddedInertia& added) {
  std::vector<Entry> entries;
  for (const StiffPart& part : parts) {
    const double factor = part.is_triangle() ? added.membrane : added.bending;
    const StiffPart::Matrix matrix = part.matrix(model);
    std::array<std::int32_t, StiffPart::kMaxVertices> at{};
    for (std::size_t a = 0; a < at.size(); ++a) {
      if (matrix.vertex[a] == mesh::kNone) continue;
      at[a] = static_cast<std::int32_t>(std::lower_bound(members.begin(), members.end(), matrix.vertex[a]) -
                                        members.begin());
    }
    for (std::size_t a = 0; a < at.size(); ++a) {
      for (std::size_t b = 0; b < at.size(); ++b) {
        if (matrix.vertex[a] == mesh::kNone || matrix.vertex[b] == mesh::kNone || at[a] < at[b]) continue;
        entries.push_back({at[a], at[b], factor * matrix.value[a][b]});
      }
    }
  }
  const auto by_place = [](const Entry& entry) { return std::tuple(entry.row, entry.column); };
  std::stable_sort(entries.begin(), entries.end(),
                   [&](const Entry& a, const Entry& b) { return by_place(a) < by_place(b); });
  std::size_t size = 0;
  for (const Entry& entry : entries) {
    if (size > 0 && by_place(entries[size - 1]) == by_place(entry)) {
      entries[size - 1].value += entry.value;
    } else {
      entries[size++] = entry;
    }
  }
  entries.resize(size);
  return entries;
}

// Sets vertices_ and place_, and renumbers the entries by place.
void InertiaCluster::set_order(std::span<const VertexId> members, std::vector<Entry>& entries) {
  const auto n = static_cast<Eigen::Index>(members.size());
  std::vector<Eigen::Triplet<double, int>> triplets;
  triplets.reserve(entries.size());
  for (const Entry& entry : entries) triplets.emplace_back(entry.row, entry.column, 1.0);
  Eigen::SparseMatrix<double> lower(n, n);
  lower.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), order);
  vertices_.resize(members.size());
  place_.resize(members.size());
  for (Eigen::Index place = 0; place < n; ++place) {
    const auto member = static_cast<std::size_t>(order.indices()[place]);
    vertices_[static_cast<std::size_t>(place)] = members[member];
    place_[member] = static_cast<std::int32_t>(place);
  }
  for (Entry& entry : entries) {
    const std::int32_t a = place_[static_cast<std::size_t>(entry.row)];
    const std::int32_t b = place_[static_cast<std::size_t>(entry.column)];
    entry.row = std::max(a, b);
    entry.column = std::min(a, b);
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return std::tuple(a.row, a.column) < std::tuple(b.row, b.column); });
}

void InertiaCluster::set_matrix(const Model& model, std::span<const Entry> entries) {
  const std::size_t n = vertices_.size();
  mass_.resize(n);
  for (std::size_t i = 0; i < n; ++i) mass_[i] = model.mass()[static_cast<std::size_t>(vertices_[i])];
  matrix_starts_.assign(n + 1, 0);
  double largest = 0.0;
  // Each row ends with its diagonal: every member is a vertex of a part.
  for (const Entry& entry : entries) {
    const auto row = static_cast<std::size_t>(entry.row);
    double value = entry.value;
    if (entry.row == entry.column) {
      value += mass_[row];
      largest = std::max(largest, value);
    }
    matrix_columns_.push_back(entry.column);
    matrix_.push_back(value);
    matrix_starts_[row + 1] = matrix_.size();
  }
  total_mass_ = std::accumulate(mass_.begin(), mass_.end(), 0.0);
  spread_ = largest / *std::min_element(mass_.begin(), mass_.end());
}

void InertiaCluster::set_pattern() {
  const std::size_t n = vertices_.size();
  parent_.assign(n, -1);
  mark_.assign(n, -1);
  std::vector<std::size_t> counts(n, 0);
  for (std::size_t k = 0; k < n; ++k) {
    mark_[k] = static_cast<std::int32_t>(k);
    for (std::size_t p = matrix_starts_[k]; p < matrix_starts_[k + 1]; ++p) {
      for (std::int32_t i = matrix_columns_[p]; mark_[static_cast<std::size_t>(i)] != static_cast<std::int32_t>(k);
           i = parent_[static_cast<std::size_t>(i)]) {
        if (parent_[static_cast<std::size_t>(i)] < 0)
          parent_[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(k);
        ++counts[static_cast<std::size_t>(i)];
        mark_[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(k);
      }
    }
  }
  starts_.assign(n + 1, 0);
  for (std::size_t i = 0; i < n; ++i) starts_[i + 1] = starts_[i] + counts[i];
  rows_.resize(starts_[n]);
  for (std::size_t set = 0; set < 3; ++set) {
    numbers_[set] = {std::vector<double>(rows_.size()), std::vector<double>(n), {}};
    rounded_[set] = {std::vector<float>(rows_.size()), std::vector<float>(n), {}};
  }
  row_.assign(n, 0.0);
  stack_.resize(n);
  filled_.resize(n);
}

bool InertiaCluster::has_whole_elements(const Model& model, std::span<const VertexId> members) const {
  const auto is_member = [members](VertexId v) { return std::binary_search(members.begin(), members.end(), v); };
  return std::all_of(members.begin(), members.end(), [&](VertexId v) {
    const std::span<const mesh::TriangleId> slots = model.elements().incident_slots().row(v);
    const bool has_triangles = std::all_of(slots.begin(), slots.end(), [&](mesh::TriangleId slot) {
      const auto corners = StiffPart::triangle(slot).vertices(model);
      return std::all_of(corners.begin(), corners.end(), [&](VertexId w) { return w == mesh::kNone || is_member(w); });
    });
    if (!has_triangles || !model.materials().has_bending()) return has_triangles;
    const std::span<const BendingEntry> row = model.bending().rows().row(v);
    return std::all_of(row.begin(), row.end(), [&](const BendingEntry& entry) { return is_member(entry.column); });
  });
}

void InertiaCluster::factor(std::size_t set, std::uint8_t components) {
  const std::size_t n = vertices_.size();
  std::vector<double>& L = numbers_[set].values;
  std::vector<double>& inverse_diagonal = numbers_[set].inverse_diagonal;
  const auto is_held = [&](std::size_t i) { return (held_[i] & components) != 0; };
  for (std::size_t i = 0; i < n; ++i) {
    filled_[i] = starts_[i];
    mark_[i] = -1;
  }
  for (std::size_t k = 0; k < n; ++k) {
    // Columns of row k, in the order of the elimination tree.
    std::size_t top = n;
    mark_[k] = static_cast<std::int32_t>(k);
    for (std::size_t p = matrix_starts_[k]; p < matrix_starts_[k + 1]; ++p) {
      const auto column = static_cast<std::size_t>(matrix_columns_[p]);
      row_[column] = column != k && (is_held(k) || is_held(column)) ? 0.0 : matrix_[p];
      std::size_t length = 0;
      for (std::size_t i = column; mark_[i] != static_cast<std::int32_t>(k); i = static_cast<std::size_t>(parent_[i])) {
        stack_[length++] = static_cast<std::int32_t>(i);
        mark_[i] = static_cast<std::int32_t>(k);
      }
      while (length > 0) stack_[--top] = stack_[--length];
    }
    double diagonal = row_[k];
    row_[k] = 0.0;
    for (; top < n; ++top) {
      const auto i = static_cast<std::size_t>(stack_[top]);
      const double y = row_[i];
      row_[i] = 0.0;
      std::size_t p = starts_[i];
      for (; p < filled_[i]; ++p) row_[static_cast<std::size_t>(rows_[p])] -= L[p] * y;
      const double value = y * inverse_diagonal[i];
      diagonal -= value * y;
      rows_[p] = static_cast<std::int32_t>(k);
      L[p] = value;
      ++filled_[i];
    }
    inverse_diagonal[k] = 1.0 / diagonal;
  }
  // A held component does not respond.
  for (std::size_t i = 0; i < n; ++i) {
    if (is_held(i)) inverse_diagonal[i] = 0.0;
  }
  const auto round = [](double value) { return static_cast<float>(value); };
  std::transform(L.begin(), L.end(), rounded_[set].values.begin(), round);
  std::transform(inverse_diagonal.begin(), inverse_diagonal.end(), rounded_[set].inverse_diagonal.begin(), round);
}

bool InertiaCluster::is_dense() const {
  constexpr std::size_t kPerEntry = 8;  // entries of an inverse that take as long as one entry of the factor
  // -, largest spread of a cluster with a dense inverse. In floats its error is 2^-24 of the response of soft modes.
  // That must stay far below the response of stiff modes.
  constexpr double kMostSpread = 1e4;
  const std::size_t n = vertices_.size();
  return n <= kMostDense && n * n <= kPerEntry * (rows_.size() + n) && spread_ <= kMostSpread;
}

// Leaves the common motion, 1 1^T / m, out of the inverse unless something is held: see solve().
void InertiaCluster::invert() {
  const std::size_t n = vertices_.size();
  numbers_[0].inverse.resize(n);
  rounded_[0].inverse.resize(n);
  alignas(64) std::array<double, 4 * kMostDense> columns{};  // of the inverse, four side by side
  for (std::size_t first = 0; first < n; first += 4) {
    columns.fill(0.0);
    for (std::size_t j = first; j < std::min(first + 4, n); ++j) {
      columns[4 * j + j % 4] = 1.0;
      for (std::size_t i = 0; i < n && !is_held_; ++i) columns[4 * i + j % 4] -= mass_[i] / total_mass_;
    }
    substitute(numbers_[0], columns.data());
    for (std::size_t j = first; j < std::min(first + 4, n); ++j) {
      for (std::size_t i = j; i < n; ++i) {
        const double entry = columns[4 * i + j % 4];
        numbers_[0].inverse.at(i, j) = numbers_[0].inverse.at(j, i) = entry;
        rounded_[0].inverse.at(i, j) = rounded_[0].inverse.at(j, i) = static_cast<float>(entry);
      }
    }
  }
}

void InertiaCluster::hold(std::span<const std::uint8_t> held) {
  if (std::equal(held.begin(), held.end(), held_.begin())) return;
  std::copy(held.begin(), held.end(), held_.begin());
  is_held_ = false;
  num_sets_ = 1;
  for (const std::uint8_t each : held_) {
    if (each != 0) is_held_ = true;
    if (each != 0 && each != 0b111) num_sets_ = 3;
  }
  if (num_sets_ == 1) {
    factor(0, 0b111);
    if (is_dense()) invert();
    return;
  }
  for (std::size_t set = 0; set < 3; ++set) factor(set, static_cast<std::uint8_t>(1U << set));
}

// Solves with one set of numbers for all components.
template <typename T>
void InertiaCluster::substitute(const Numbers<T>& numbers, T* values) const {
  using Four = Eigen::Array<T, 4, 1>;
  const std::size_t n = vertices_.size();
  const auto at = [values](std::size_t i) { return Eigen::Map<Four, Eigen::Aligned16>(values + 4 * i); };
  const T* const L = numbers.values.data();
  for (std::size_t j = 0; j < n; ++j) {
    const Four y = at(j);
    for (std::size_t p = starts_[j]; p < starts_[j + 1]; ++p) at(static_cast<std::size_t>(rows_[p])) -= L[p] * y;
  }
  for (std::size_t j = n; j-- > 0;) {
    Four y = numbers.inverse_diagonal[j] * at(j);
    for (std::size_t p = starts_[j]; p < starts_[j + 1]; ++p) y -= L[p] * at(static_cast<std::size_t>(rows_[p]));
    at(j) = y;
  }
}

// Solves M' y = values. The common motion is computed separately, from the sum of the impulses. Forces inside a flake
// are so large beside its weight that their rounding would throw it about.
template <typename T>
void InertiaCluster::solve(T* values, const std::array<T, 4>* external) const {
  using Four = Eigen::Array<T, 4, 1>;
  const std::size_t n = vertices_.size();
  if (num_sets_ == 1) {
    const auto at = [values](std::size_t i) { return Eigen::Map<Four, Eigen::Aligned16>(values + 4 * i); };
    const Numbers<T>& numbers = this->numbers<T>(0);
    const std::size_t num_free = is_held_ ? 0 : n;
    Four common = Four::Zero();
    if (is_piece_ && external != nullptr) {
      common = Eigen::Map<const Four>(external->data());
    } else {
      for (std::size_t i = 0; i < num_free; ++i) common += at(i);
    }
    if (numbers.inverse.size == 0) {
      substitute(numbers, values);
      for (std::size_t i = 0; i < num_free; ++i) common -= static_cast<T>(mass_[i]) * at(i);
    } else {
      alignas(64) std::array<T, 4 * kMostDense> product;
      linear::multiply(numbers.inverse, values, product.data());
      std::copy_n(product.data(), 4 * n, values);
    }
    common /= static_cast<T>(total_mass_);
    for (std::size_t i = 0; i < num_free; ++i) at(i) += common;
    return;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const Numbers<T>& numbers = this->numbers<T>(c);
    const T* const L = numbers.values.data();
    for (std::size_t j = 0; j < n; ++j) {
      const T y = values[4 * j + c];
      for (std::size_t p = starts_[j]; p < starts_[j + 1]; ++p) {
        values[4 * static_cast<std::size_t>(rows_[p]) + c] -= L[p] * y;
      }
    }
    for (std::size_t j = n; j-- > 0;) {
      T y = values[4 * j + c] * numbers.inverse_diagonal[j];
      for (std::size_t p = starts_[j]; p < starts_[j + 1]; ++p) {
        y -= L[p] * values[4 * static_cast<std::size_t>(rows_[p]) + c];
      }
      values[4 * j + c] = y;
    }
  }
}
template void InertiaCluster::solve(float* values, const std::array<float, 4>* external) const;
template void InertiaCluster::solve(double* values, const std::array<double, 4>* external) const;

}  // namespace kerf::fem
