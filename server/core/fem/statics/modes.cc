#include "server/core/fem/statics/modes.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <Spectra/MatOp/SparseSymMatProd.h>
#include <Spectra/MatOp/SymShiftInvert.h>
#include <Spectra/SymGEigsShiftSolver.h>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "server/base/check.h"
#include "server/base/elementary.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {
namespace {

// -, shift of the inverse, relative to the largest eigenvalue. It is below all eigenvalues of a stable state. It is
// also so near 0 that the lowest eigenvalues of the shifted inverse stay apart from the next.
constexpr double kShift = -1e-9;
// -, shift of the inverse, relative to the highest eigenvalue wanted. Nearer to 0 the rounding error of rigid motions,
// in proportion to 1 / shift, would be too large for the other modes.
constexpr double kShiftOfHighest = -1e-3;
constexpr double kNearer = 0.01;  // -, of the shift: eigenvalues as near to 0 or nearer are sought from a nearer shift
constexpr int kMaxRestarts = 1000;
constexpr double kTolerance = 1e-10;           // -, relative
constexpr double kSeparation = 1e-6;           // -, relative; eigenvalues closer together count as one
constexpr double kEigenvalueRounding = 1e-12;  // relative to the largest; those of rigid motions are as far from 0
constexpr int kMaxSearches = 8;

// Numbers the components that nothing holds, 3 a vertex; -1 for the others.
std::vector<int> number_free(const Model& model, const Loads& loads, int& count) {
  std::vector<int> numbers(3 * static_cast<std::size_t>(model.num_vertices()), 0);
  for (const Pin& pin : loads.pins) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (pin.fixed[c]) numbers[3 * static_cast<std::size_t>(pin.vertex) + c] = -1;
    }
  }
  count = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (model.mass()[i / 3] == 0.0) numbers[i] = -1;
    if (numbers[i] == 0) numbers[i] = count++;
  }
  return numbers;
}

using Matrix = Eigen::SparseMatrix<double>;
using Entries = std::vector<Eigen::Triplet<double>>;

Matrix assembled(const Entries& entries, int count) {
  Matrix matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// Returns the stiffness matrix of the free components, N/m.
Matrix stiffness_matrix(const Model& model, const Loads& loads, const linear::VertexField& x,
                        const std::vector<int>& numbers, int count) {
  TangentMatrix tangent;
  tangent.rebuild(model);
  tangent.set_mass(model, 0.0);
  tangent.add_membrane(model, x, {}, {}, 1.0, false);
  tangent.add_bending_at(model, x, {}, false);
  for (Grab spring : loads.grabs) {
    spring.damping = 0.0;
    tangent.add_grabs({&spring, 1}, 1.0);
  }
  tangent.add_follower_loads(model, loads, x, 1.0, MatrixPart::kSymmetric);
  const linear::BlockMatrix& blocks = tangent.blocks();
  Entries entries;
  for (int i = 0; i < blocks.num_rows(); ++i) {
    for (int at = blocks.row_begin(i); at < blocks.row_end(i); ++at) {
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
          const int row = numbers[static_cast<std::size_t>(3 * i + a)];
          const int column = numbers[static_cast<std::size_t>(3 * blocks.column(at) + b)];
          if (row >= 0 && column >= 0) entries.emplace_back(row, column, blocks.block(at)(a, b));
        }
      }
    }
  }
  return assembled(entries, count);
}

// Returns the mass matrix, kg. Lumped masses make waves slower and consistent ones (rho A / 12, twice that on the
// diagonal) faster, both by O(h^2). Across the sheet their mean is correct to a higher order (Hughes, The Finite
// Element Method, section 7.3.2). Within it triangles of constant strain are too stiff by about as much as lumped
// masses compensate.
Matrix mass_matrix(const Model& model, const linear::VertexField& x, const std::vector<int>& numbers, int count) {
  Entries entries;
  const auto add = [&](mesh::VertexId v, mesh::VertexId w, const Eigen::Matrix3d& m) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        const int row = numbers[3 * static_cast<std::size_t>(v) + a];
        const int column = numbers[3 * static_cast<std::size_t>(w) + b];
        if (row < 0 || column < 0) continue;
        entries.emplace_back(row, column, m(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)));
      }
    }
  };
  for (const ElementBlock& block : model.element_blocks()) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double mass = model.materials().of(block, l).surface_density * block.area[l];
      if (mass == 0.0) continue;
      const Eigen::Vector3d corner = x.col(block.vertex[0][l]);
      const Eigen::Vector3d side = x.col(block.vertex[1][l]) - corner;
      const Eigen::Vector3d other = x.col(block.vertex[2][l]) - corner;
      const Eigen::Vector3d normal = side.cross(other).stableNormalized();
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          const double lumped = i == j ? mass / 3.0 : 0.0;
          const double consistent = mass / (i == j ? 6.0 : 12.0);
          add(block.vertex[i][l], block.vertex[j][l],
              lumped * Eigen::Matrix3d::Identity() + 0.5 * (consistent - lumped) * normal * normal.transpose());
        }
      }
    }
  }
  return assembled(entries, count);
}

struct Stopped {};

// The operator (K - shift M)^-1 on the M-orthogonal complement of the vectors already found, in the form Spectra
// requires.
class DeflatedInverse {
 public:
  using Scalar = double;
  // Throws Stopped if `stop` returns true: Spectra can only be left by an exception.
  DeflatedInverse(const Matrix& stiffness, const Matrix& mass, const Eigen::MatrixXd& found, const StopCondition& stop)
      : inverse_(stiffness, mass), found_(found), weighted_(mass * found), stop_(stop) {}
  [[nodiscard]] Eigen::Index rows() const { return inverse_.rows(); }
  [[nodiscard]] Eigen::Index cols() const { return inverse_.cols(); }
  void set_shift(double shift) { inverse_.set_shift(shift); }
  void perform_op(const double* in, double* out) const {
    if (stop_ && stop_()) throw Stopped();
    inverse_.perform_op(in, out);
    Eigen::Map<Eigen::VectorXd> y(out, rows());
    y -= found_ * (weighted_.transpose() * y);
  }

 private:
  Spectra::SymShiftInvert<double> inverse_;
  const Eigen::MatrixXd& found_;
  Eigen::MatrixXd weighted_;
  const StopCondition& stop_;
};

struct Pairs {
  Eigen::VectorXd values;  // ascending
  Eigen::MatrixXd vectors;
  bool converged = false;
};

// Returns the `count` eigenvalues next to the shift and their vectors, without those in `found`. `search` varies the
// start of the iteration.
Pairs lanczos(const Matrix& stiffness, const Matrix& mass, const Eigen::MatrixXd& found, int count, double shift,
              int search, const StopCondition& stop) {
  using Product = Spectra::SparseSymMatProd<double>;
  DeflatedInverse inverse(stiffness, mass, found, stop);
  Product product(mass);
  const auto size = static_cast<int>(stiffness.rows());
  const int num_vectors = std::min(size, std::max(2 * count + 1, 20));
  Spectra::SymGEigsShiftSolver<DeflatedInverse, Product, Spectra::GEigsMode::ShiftInvert> solver(
      inverse, product, count, num_vectors, shift);
  // Replaces the default random start, so that the same state gives the same modes.
  Eigen::VectorXd start(size);
  for (int i = 0; i < size; ++i) start[i] = cosine(1.0 + (1.7 + 0.3 * search) * i) + 0.5;
  start -= found * (found.transpose() * (mass * start));
  solver.init(start.data());
  const auto num_found =
      solver.compute(Spectra::SortRule::LargestMagn, kMaxRestarts, kTolerance, Spectra::SortRule::SmallestAlge);
  return {solver.eigenvalues(), solver.eigenvectors(),
          solver.info() == Spectra::CompInfo::Successful && num_found == count};
}

// Returns the lowest `count` pairs of a and b together.
Pairs merged(const Pairs& a, const Pairs& b, int count) {
  std::vector<std::pair<double, Eigen::VectorXd>> all;
  for (const Pairs* pairs : {&a, &b}) {
    for (Eigen::Index i = 0; i < pairs->values.size(); ++i) all.emplace_back(pairs->values[i], pairs->vectors.col(i));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  all.resize(std::min(all.size(), static_cast<std::size_t>(count)));
  Pairs pairs{Eigen::VectorXd(all.size()), Eigen::MatrixXd(a.vectors.rows(), all.size()), a.converged && b.converged};
  for (std::size_t i = 0; i < all.size(); ++i) {
    pairs.values[static_cast<Eigen::Index>(i)] = all[i].first;
    pairs.vectors.col(static_cast<Eigen::Index>(i)) = all[i].second;
  }
  return pairs;
}

// Returns the number of eigenvalues below `value`. It is the number of negative pivots of K - value M (Sylvester's law
// of inertia). Returns 0 if the factorisation fails.
int num_below(const Matrix& stiffness, const Matrix& mass, double value) {
  const Eigen::SimplicialLDLT<Matrix> factor(stiffness - value * mass);
  if (factor.info() != Eigen::Success) return 0;
  return static_cast<int>((factor.vectorD().array() < 0.0).count());
}

// Returns a shift below all eigenvalues, also for an unstable state, so that the eigenvalues next to it are the lowest.
double shift_below(const Matrix& stiffness, const Matrix& mass, double unit) {
  double shift = kShift * unit;
  while (shift > -unit && num_below(stiffness, mass, shift) > 0) shift *= 10.0;
  return shift;
}

// Returns how many of the lowest `count` eigenvalues are missing; `values` has one more. A Krylov space holds one
// vector of a multiple eigenvalue, and rounding need not bring in its other vectors. Eigenvalues are counted up to the
// middle of the highest gap between the values found. Nearer to an eigenvalue, pivots in a fixed order are inexact.
int num_missed(const Matrix& stiffness, const Matrix& mass, const Eigen::VectorXd& values, int count, double unit) {
  for (Eigen::Index k = count; k > 0; --k) {
    const double gap = values[k] - values[k - 1];
    if (!(gap > kSeparation * std::abs(values[k]) + kEigenvalueRounding * unit)) continue;
    return std::max(0, num_below(stiffness, mass, values[k] - 0.5 * gap) - static_cast<int>(k));
  }
  return 0;
}

// Finds the lowest `count` eigenvalues and vectors. Throws Stopped, and the exceptions of Spectra if a factorisation
// fails.
Pairs lowest(const Matrix& stiffness, const Matrix& mass, double unit, int count, const StopCondition& stop) {
  const double nearest = kShift * unit;
  double shift = shift_below(stiffness, mass, unit);
  const bool is_stable = shift == nearest;
  Pairs found{Eigen::VectorXd(0), Eigen::MatrixXd(stiffness.rows(), 0), true};
  const auto seek = [&](int total) {
    const int sought = total - static_cast<int>(found.values.size());
    if (sought > 0) found = merged(found, lanczos(stiffness, mass, found.vectors, sought, shift, 0, stop), total);
  };
  while (shift < nearest && found.converged) {
    // All eigenvalues much nearer to 0 than the shift look alike from there. They are found later, from nearer by.
    const double nearer = std::min(kNearer * shift, nearest);
    seek(std::min(count, num_below(stiffness, mass, nearer)));
    shift = nearer;
  }
  if (found.converged) seek(count);
  const double farther = found.converged ? kShiftOfHighest * std::abs(found.values[count - 1]) : shift;
  if (is_stable && farther < shift) {
    shift = farther;
    found = lanczos(stiffness, mass, Eigen::MatrixXd(stiffness.rows(), 0), count, shift, 0, stop);
  }
  const auto count_missed = [&] {
    return found.converged ? num_missed(stiffness, mass, found.values, count - 1, unit) : 0;
  };
  int missing = count_missed();
  for (int search = 1; search < kMaxSearches && missing > 0; ++search) {
    // A sheet in many pieces may miss hundreds; only the lowest `count` are needed.
    const int sought = std::min(missing, count);
    found = merged(found, lanczos(stiffness, mass, found.vectors, sought, shift, search, stop), count);
    missing = count_missed();
  }
  found.converged = found.converged && missing == 0;
  return found;
}

}  // namespace

int num_free_components(const Model& model, const Loads& loads) {
  int count = 0;
  number_free(model, loads, count);
  return count;
}

Modes find_modes(const Model& model, const Loads& loads, const linear::VertexField& x, int count,
                 const StopCondition& stop) {
  int num_free = 0;
  const std::vector<int> numbers = number_free(model, loads, num_free);
  KERF_CHECK(count >= 1 && count <= kMaxModes && count < num_free, "as many modes as find_modes() can find");
  const Matrix stiffness = stiffness_matrix(model, loads, x, numbers, num_free);
  const Matrix mass = mass_matrix(model, x, numbers, num_free);
  Modes modes;
  Pairs found;
  try {
    found = lowest(stiffness, mass, model.stiffness_bound().value(), std::min(count + 1, num_free - 1), stop);
  } catch (const Stopped&) {
    modes.stopped = true;
    return modes;
  } catch (const std::exception&) {  // Spectra's, for a matrix without a factor
    return modes;
  }
  modes.converged = found.converged;
  const Eigen::Index num_found = std::min<Eigen::Index>(count, found.values.size());
  modes.eigenvalues = found.values.head(num_found);
  const Eigen::MatrixXd vectors = found.vectors.leftCols(num_found);
  modes.shapes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(numbers.size()), vectors.cols());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] < 0) continue;
    modes.shapes.row(static_cast<Eigen::Index>(i)) = vectors.row(numbers[i]);
  }
  return modes;
}

}  // namespace kerf::fem
