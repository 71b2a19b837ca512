#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "server/core/fem/model/model.h"
#include "server/core/fem/model/stiff_parts.h"
#include "server/core/linear/dense_fours.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// s^2, of M' = M + membrane z L + bending Q.
struct AddedInertia {
  double membrane = 0.0;
  double bending = 0.0;
  bool operator==(const AddedInertia&) const = default;
};

// The inertia M' = M + added (sum of stiff parts) of some vertices, and its Cholesky factor L D L^T: a function of the
// parts, the masses and what is held, not of how they came about. M' is the same for x, y and z. Vertices are kept in
// the order of elimination, of minimum degree (Amestoy, Davis, Duff 1996); the factor is made row by row (Davis 2005,
// "Algorithm 849: a concise sparse Cholesky factorization package"). Small ones are solved by their dense inverse,
// whose products need not wait for each other.
class InertiaCluster {
 public:
  // members: ascending. parts: ascending, their vertices among the members.
  InertiaCluster(const Model& model, std::span<const mesh::VertexId> members, std::span<const StiffPart> parts,
                 const AddedInertia& added);

  [[nodiscard]] std::span<const mesh::VertexId> vertices() const { return vertices_; }
  [[nodiscard]] mesh::VertexId lowest() const { return lowest_; }
  [[nodiscard]] std::span<const StiffPart> parts() const { return parts_; }
  [[nodiscard]] std::size_t num_entries() const { return rows_.size(); }  // of L below its diagonal
  [[nodiscard]] double mass(std::size_t i) const { return mass_[i]; }     // kg, of vertices()[i]
  // -, the largest diagonal entry of M' over the least mass.
  [[nodiscard]] double spread() const { return spread_; }

  // Takes rows and columns of held components out: bit c of held[k] is component c of vertices()[k]. Nothing where they
  // are held already. Does not allocate.
  void hold(std::span<const std::uint8_t> held);
  [[nodiscard]] std::span<const std::uint8_t> held() const { return held_; }
  [[nodiscard]] bool is_held() const { return is_held_; }    // any component
  [[nodiscard]] bool is_piece() const { return is_piece_; }  // no element has a vertex inside and one outside

  // values: x, y, z and one more of each of vertices(), N s, aligned to 64 bytes. Becomes M'^-1 values, m/s, 0 where it
  // is held. `external`, N s, may be null: the sum of those that are not the sheet's own. Its own sum to 0 in a loose
  // piece that is all in the cluster, whatever rounding left of them.
  template <typename T>
  void solve(T* values, const std::array<T, 4>* external = nullptr) const;
  // visit(i, j, entry) of each entry of M' - M on and below its diagonal, kg; i, j: vertices.
  template <typename Visit>
  void for_each_added(const Visit& visit) const {
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      for (std::size_t p = matrix_starts_[i]; p < matrix_starts_[i + 1]; ++p) {
        const auto j = static_cast<std::size_t>(matrix_columns_[p]);
        visit(vertices_[i], vertices_[j], i == j ? matrix_[p] - mass_[i] : matrix_[p]);
      }
    }
  }

 private:
  static constexpr std::size_t kMostDense = 32;  // vertices
  struct Entry {                                 // of a symmetric matrix, row >= column
    std::int32_t row = 0, column = 0;
    double value = 0.0;
  };
  // L below its diagonal of 1, by columns, and 1 / D; of all components alike, or of each.
  template <typename T>
  struct Numbers {
    std::vector<T> values;
    std::vector<T> inverse_diagonal;
    DenseFours<T> inverse;  // of M', without what moves all alike unless something is held; or of size 0
  };
  // Added, kg.
  static std::vector<Entry> sum_of(const Model& model, std::span<const mesh::VertexId> members,
                                   std::span<const StiffPart> parts, const AddedInertia& added);
  void set_order(std::span<const mesh::VertexId> members, std::vector<Entry>& entries);
  void set_matrix(const Model& model, std::span<const Entry> entries);
  void set_pattern();
  [[nodiscard]] bool has_whole_elements(const Model& model, std::span<const mesh::VertexId> members) const;
  // Factors M' without vertices held in these components, into one set of numbers.
  void factor(std::size_t set, std::uint8_t components);
  [[nodiscard]] bool is_dense() const;
  template <typename T>
  void substitute(const Numbers<T>& numbers, T* values) const;
  // Sets the inverse that is the same for all components.
  void invert();

  std::vector<mesh::VertexId> vertices_;
  mesh::VertexId lowest_ = mesh::kNone;
  std::vector<StiffPart> parts_;
  std::vector<std::int32_t> place_;  // of the members, in vertices_
  double spread_ = 1.0;

  // M', kg, its lower triangle by rows, the diagonal last; mass_, kg.
  std::vector<std::size_t> matrix_starts_;
  std::vector<std::int32_t> matrix_columns_;
  std::vector<double> matrix_;
  std::vector<double> mass_;
  double total_mass_ = 0.0;  // kg
  template <typename T>
  [[nodiscard]] const Numbers<T>& numbers(std::size_t set) const {
    if constexpr (std::is_same_v<T, float>)
      return rounded_[set];
    else
      return numbers_[set];
  }
  std::vector<std::size_t> starts_;
  std::vector<std::int32_t> rows_;
  std::array<Numbers<double>, 3> numbers_;
  std::array<Numbers<float>, 3> rounded_;
  std::size_t num_sets_ = 1;
  std::vector<std::int32_t> parent_;  // elimination tree
  std::vector<std::uint8_t> held_;
  bool is_held_ = false;
  bool is_piece_ = false;

  // Scratch of factor().
  std::vector<double> row_;
  std::vector<std::int32_t> mark_, stack_;
  std::vector<std::size_t> filled_;
};

}  // namespace kerf::fem
