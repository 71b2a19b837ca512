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

// Coefficients (s^2) of the added inertia M' = M + membrane z L + bending Q. L and Q are sums over stiff parts, see
// LocalInertia.
struct AddedInertia {
  double membrane = 0.0;
  double bending = 0.0;
  bool operator==(const AddedInertia&) const = default;
};

// The inertia M' = M + added (sum of stiff parts) of some vertices, and its Cholesky factor L D L^T. It is a function
// of the parts, the masses and the components that pins hold, whatever edits led to them. M' is the same for x, y and
// z. Vertices are in the order of elimination, of minimum degree (Amestoy, Davis, Duff 1996). The factor is computed
// row by row (Davis 2005, "Algorithm 849: a concise sparse Cholesky factorization package"). Small clusters are solved
// with their dense inverse, whose products do not depend on each other.
class InertiaCluster {
 public:
  // Builds the cluster. `members` and `parts` ascend; the vertices of the parts are among the members.
  InertiaCluster(const Model& model, std::span<const mesh::VertexId> members, std::span<const StiffPart> parts,
                 const AddedInertia& added);

  [[nodiscard]] std::span<const mesh::VertexId> vertices() const { return vertices_; }
  [[nodiscard]] mesh::VertexId lowest() const { return lowest_; }
  [[nodiscard]] std::span<const StiffPart> parts() const { return parts_; }
  [[nodiscard]] std::size_t num_entries() const { return rows_.size(); }  // of L below its diagonal
  [[nodiscard]] double mass(std::size_t i) const { return mass_[i]; }     // kg, of vertices()[i]
  // -, largest diagonal entry of M' over the least mass.
  [[nodiscard]] double spread() const { return spread_; }

  // Removes the rows and columns of the components that pins hold: bit c of held[k] is component c of vertices()[k].
  // Does nothing if exactly these are held already. Does not allocate.
  void hold(std::span<const std::uint8_t> held);
  [[nodiscard]] std::span<const std::uint8_t> held() const { return held_; }
  [[nodiscard]] bool is_held() const { return is_held_; }  // true if any component is held
  // True if no element has vertices both in the cluster and outside.
  [[nodiscard]] bool is_piece() const { return is_piece_; }

  // Replaces values by M'^-1 values, m/s, 0 in held components. `values` has x, y, z and a fourth number for each of
  // vertices(), N s, aligned to 64 bytes. `external`, N s, is the sum of the impulses that do not come from the sheet
  // itself; it may be null. The sheet's own impulses sum to 0 in a loose piece that lies wholly in the cluster, so
  // their rounded sum is ignored there.
  template <typename T>
  void solve(T* values, const std::array<T, 4>* external = nullptr) const;
  // Calls visit(i, j, entry) for each entry of M' - M on and below its diagonal, kg; i and j are vertices.
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
  // L below its unit diagonal, by columns, and 1 / D; one set for all components, or one for each.
  template <typename T>
  struct Numbers {
    std::vector<T> values;
    std::vector<T> inverse_diagonal;
    linear::DenseFours<T> inverse;  // dense inverse of M', size 0 if unused. If nothing is held it lacks the motion
                                    // that all vertices have in common, which solve() adds
  };
  // Returns the entries of the added inertia, kg.
  static std::vector<Entry> sum_of(const Model& model, std::span<const mesh::VertexId> members,
                                   std::span<const StiffPart> parts, const AddedInertia& added);
  void set_order(std::span<const mesh::VertexId> members, std::vector<Entry>& entries);
  void set_matrix(const Model& model, std::span<const Entry> entries);
  void set_pattern();
  [[nodiscard]] bool has_whole_elements(const Model& model, std::span<const mesh::VertexId> members) const;
  // Factors M', with vertices removed that are held in any of these components, into one set of numbers.
  void factor(std::size_t set, std::uint8_t components);
  [[nodiscard]] bool is_dense() const;
  template <typename T>
  void substitute(const Numbers<T>& numbers, T* values) const;
  // Sets the dense inverse. The held components must be the same for x, y and z.
  void invert();

  std::vector<mesh::VertexId> vertices_;
  mesh::VertexId lowest_ = mesh::kNone;
  std::vector<StiffPart> parts_;
  std::vector<std::int32_t> place_;  // index in vertices_ of each member, by ascending vertex
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
