// Sparse factors: the elimination order and its supernodes, the factor against a dense one, and matrices that are not
// positive definite. Results have the same bits on all processors.
#include "server/core/linear/supernodal_cholesky.h"

#include <algorithm>
#include <limits>
#include <set>
#include <vector>

#include <Eigen/Cholesky>

#include "server/core/linear/supernodes.h"
#include "tests/fem/instruction_sets.h"
#include "tests/fem/linear_systems.h"
#include "tests/support/matrix_near.h"

namespace kerf::fem {
namespace {

// Returns the lower triangle's pattern by columns of the elimination order, vertices.
std::vector<std::set<int>> dense_pattern(const linear::BlockMatrix& A, const linear::Supernodes& supernodes) {
  const int n = A.num_rows();
  std::vector<std::set<int>> rows(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    for (int at = A.row_begin(i); at < A.row_end(i); ++at) {
      const int a = supernodes.new_from_old(i);
      const int b = supernodes.new_from_old(A.column(at));
      rows[static_cast<std::size_t>(std::min(a, b))].insert(std::max(a, b));
    }
  }
  for (std::set<int>& column : rows) {
    if (column.size() < 2) continue;
    const auto parent = std::next(column.begin());
    rows[static_cast<std::size_t>(*parent)].insert(parent, column.end());
  }
  return rows;
}

// Two sheets that know nothing of each other: two trees.
System two_systems(int side, std::uint64_t seed) {
  const System one = random_system(side, 10.0, seed);
  const int n = one.A.num_rows();
  System both;
  both.A.resize(2 * n);
  for (const int shift : {0, n}) {
    for (int i = 0; i < n; ++i) {
      std::vector<int> columns;
      for (int at = one.A.row_begin(i); at < one.A.row_end(i); ++at) columns.push_back(one.A.column(at) + shift);
      both.A.set_row(i + shift, columns);
    }
  }
  both.A.set_zero();
  both.dense = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  for (const int shift : {0, n}) {
    for (int i = 0; i < n; ++i) {
      for (int at = one.A.row_begin(i); at < one.A.row_end(i); ++at) {
        const int j = one.A.column(at);
        both.A.block(both.A.find(i + shift, j + shift)) = one.A.block(at);
        both.dense.block<3, 3>(3 * (i + shift), 3 * (j + shift)) = one.A.block(at);
      }
    }
  }
  return both;
}

std::vector<System> systems() {
  std::vector<System> all;
  for (const int side : {2, 3, 7, 12}) all.push_back(random_system(side, 100.0, 40 + static_cast<std::uint64_t>(side)));
  all.push_back(two_systems(6, 3));
  return all;
}

struct Solved {
  bool factorised = false;
  std::size_t replaced = 0;
  linear::VertexField x;
};

template <typename T>
Solved solved(const System& system, std::span<const Eigen::Matrix3d> frames, const linear::VertexField& b,
              bool replaces = false) {
  linear::SupernodalCholesky<T> factor;
  factor.analyse(system.A);
  linear::PivotRule<T> rule;
  rule.replaces = replaces;
  Solved result;
  result.factorised = factor.factorise(system.A, frames, rule);
  result.replaced = rule.replaced;
  result.x = Eigen::Matrix3Xd::Zero(3, b.cols());
  if (result.factorised) factor.solve(b, result.x);
  return result;
}

TEST(Supernodes, HoldThePatternOfTheFactorInAPostorder) {
  for (const System& system : systems()) {
    linear::Supernodes supernodes;
    supernodes.analyse(system.A);
    const int n = system.A.num_rows();
    ASSERT_EQ(supernodes.num_vertices(), n);
    for (int v = 0; v < n; ++v) EXPECT_EQ(supernodes.old_from_new(supernodes.new_from_old(v)), v);
    const std::vector<std::set<int>> exact = dense_pattern(system.A, supernodes);
    int next = 0;
    for (int s = 0; s < supernodes.size(); ++s) {
      ASSERT_EQ(supernodes.first(s), next);
      ASSERT_GT(supernodes.width(s), 0);
      next += supernodes.width(s);
      const std::span<const int> rows = supernodes.rows(s);
      EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end()));
      for (int j = 0; j < supernodes.width(s); ++j) {
        EXPECT_EQ(rows[static_cast<std::size_t>(j)], supernodes.first(s) + j);
        for (const int i : exact[static_cast<std::size_t>(supernodes.first(s) + j)]) {
          EXPECT_TRUE(std::binary_search(rows.begin(), rows.end(), i));
        }
      }
      const std::span<const int> places = supernodes.rows_in_parent(s);
      ASSERT_EQ(places.size(), rows.size() - static_cast<std::size_t>(supernodes.width(s)));
      if (supernodes.parent(s) == -1) {
        EXPECT_TRUE(places.empty());
        continue;
      }
      EXPECT_GT(supernodes.parent(s), s);
      for (std::size_t i = 0; i < places.size(); ++i) {
        EXPECT_EQ(supernodes.rows(supernodes.parent(s))[static_cast<std::size_t>(places[i])],
                  rows[i + static_cast<std::size_t>(supernodes.width(s))]);
      }
    }
    EXPECT_EQ(next, n);
  }
}

TEST(SupernodalCholesky, SolvesAsADenseFactorDoes) {
  SeededRandom random(5);
  for (const System& system : systems()) {
    const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
    const Eigen::VectorXd exact = system.dense.llt().solve(Eigen::VectorXd(b.reshaped()));
    const double scale = exact.cwiseAbs().maxCoeff();
    const Solved in_double = solved<double>(system, {}, b);
    ASSERT_TRUE(in_double.factorised);
    EXPECT_THAT(in_double.x.reshaped(), test::MatrixNear(exact, 1e-11 * scale));
    const Solved in_float = solved<float>(system, {}, b);
    ASSERT_TRUE(in_float.factorised);
    EXPECT_THAT(in_float.x.reshaped(), test::MatrixNear(exact, 3e-3 * scale));
    EXPECT_GT((in_float.x.reshaped() - exact).cwiseAbs().maxCoeff(), 1e-9 * scale) << "floats were not used";
  }
}

TEST(SupernodalCholesky, FactorsInFramesOfItsVertices) {
  SeededRandom random(6);
  const System system = random_system(7, 100.0, 8);
  const auto n = static_cast<std::size_t>(system.A.num_rows());
  std::vector<Eigen::Matrix3d> frames(n);
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(system.dense.rows(), system.dense.cols());
  for (std::size_t i = 0; i < n; ++i) {
    frames[i] = random_rotation(random);
    Q.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * i)) = frames[i];
  }
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  const Eigen::MatrixXd turned = Q.transpose() * system.dense * Q;
  const Eigen::VectorXd exact = turned.llt().solve(Eigen::VectorXd(b.reshaped()));
  const Solved found = solved<double>(system, frames, b);
  ASSERT_TRUE(found.factorised);
  EXPECT_THAT(found.x.reshaped(), test::MatrixNear(exact, 1e-11 * exact.cwiseAbs().maxCoeff()));
}

template <typename T>
void expect_equal_on_all_instruction_sets() {
  SeededRandom random(7);
  for (const System& system : systems()) {
    const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
    std::vector<linear::VertexField> found;
    for_each_instruction_set([&] { found.push_back(solved<T>(system, {}, b).x); });
    for (const linear::VertexField& x : found) EXPECT_EQ(x, found.front());
  }
}

TEST(SupernodalCholesky, GivesTheSameBitsOnEveryInstructionSet) {
  expect_equal_on_all_instruction_sets<float>();
  expect_equal_on_all_instruction_sets<double>();
}

TEST(SupernodalCholesky, RefusesOrReplacesPivotsThatAreNotPositive) {
  SeededRandom random(9);
  System system = random_system(6, 1.0, 3);
  system.A.block(system.A.diagonal(7))(1, 1) = 1e-3;  // positive, but less than its row has beside it
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  EXPECT_FALSE(solved<double>(system, {}, b).factorised);
  const Solved replaced = solved<float>(system, {}, b, true);
  EXPECT_TRUE(replaced.factorised);
  EXPECT_GT(replaced.replaced, 0U);
  EXPECT_TRUE(replaced.x.allFinite());
  system.A.block(system.A.diagonal(7))(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solved<float>(system, {}, b, true).factorised);
}

}  // namespace
}  // namespace kerf::fem
