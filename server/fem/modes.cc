#include "server/fem/modes.h"

#include <algorithm>
#include <cmath>

#include <Spectra/MatOp/SparseSymMatProd.h>
#include <Spectra/MatOp/SymShiftInvert.h>
#include <Spectra/SymGEigsShiftSolver.h>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>

#include "server/base/check.h"

namespace kerf::fem {
namespace {

// Below all eigenvalues of a stable state, and so near 0 that the lowest stay apart from the next; over the largest.
constexpr double kShift = -1e-9;
constexpr int kMaxRestarts = 1000;
constexpr double kTolerance = 1e-10;  // -, relative

// Numbers of the components that nothing holds, 3 a vertex; -1 for the others.
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

// N/m
Matrix stiffness_matrix(const Model& model, const Loads& loads, const mesh::VertexField& x,
                        const std::vector<int>& numbers, int count) {
  TangentMatrix tangent;
  tangent.rebuild(model);
  tangent.set_mass(model, 0.0);
  tangent.add_membrane(model, x, {}, 1.0, 1.0, false);
  tangent.add_bending(model, 1.0);
  for (Grab spring : loads.grabs) {
    spring.damping = 0.0;
    tangent.add_grabs({&spring, 1}, 1.0);
  }
  tangent.add_follower_loads(model, loads, x, 1.0, MatrixPart::kSymmetric);
  const BlockMatrix& blocks = tangent.blocks();
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

// kg. Lumped masses make waves slower and consistent ones (rho A / 12, twice that on the diagonal) faster, both by
// O(h^2). Across the sheet their mean is right to a higher order (Hughes, The Finite Element Method, section 7.3.2);
// within it triangles of constant strain are stiffer than the sheet by about what lumped masses make up for.
Matrix mass_matrix(const Model& model, const mesh::VertexField& x, const std::vector<int>& numbers, int count) {
  const double density = model.material().density * model.material().thickness;
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
      const double mass = density * block.area[l];
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

}  // namespace

int num_free_components(const Model& model, const Loads& loads) {
  int count = 0;
  number_free(model, loads, count);
  return count;
}

Modes find_modes(const Model& model, const Loads& loads, const mesh::VertexField& x, int count) {
  int num_free = 0;
  const std::vector<int> numbers = number_free(model, loads, num_free);
  KERF_CHECK(count >= 1 && count <= kMaxModes && count < num_free, "as many modes as find_modes() can find");
  const Matrix stiffness = stiffness_matrix(model, loads, x, numbers, num_free);
  const Matrix mass = mass_matrix(model, x, numbers, num_free);
  using Inverse = Spectra::SymShiftInvert<double>;
  using Product = Spectra::SparseSymMatProd<double>;
  Inverse inverse(stiffness, mass);
  Product product(mass);
  const int num_vectors = std::min(num_free, std::max(2 * count + 1, 20));
  Spectra::SymGEigsShiftSolver<Inverse, Product, Spectra::GEigsMode::ShiftInvert> solver(
      inverse, product, count, num_vectors, kShift * model.stiffness_bound());
  // Not the default start, which is drawn at random: the same state gives the same modes.
  Eigen::VectorXd start(num_free);
  for (int i = 0; i < num_free; ++i) start[i] = std::cos(1.0 + 1.7 * i) + 0.5;
  solver.init(start.data());
  const auto found =
      solver.compute(Spectra::SortRule::LargestMagn, kMaxRestarts, kTolerance, Spectra::SortRule::SmallestAlge);
  Modes modes;
  modes.converged = solver.info() == Spectra::CompInfo::Successful && found == count;
  modes.eigenvalues = solver.eigenvalues();
  const Eigen::MatrixXd vectors = solver.eigenvectors();
  modes.shapes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(numbers.size()), vectors.cols());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] < 0) continue;
    modes.shapes.row(static_cast<Eigen::Index>(i)) = vectors.row(numbers[i]);
  }
  return modes;
}

}  // namespace kerf::fem
