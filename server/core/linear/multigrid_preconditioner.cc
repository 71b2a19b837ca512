#include "server/core/linear/multigrid_preconditioner.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "server/base/as_index.h"
#include "server/core/linear/cross_matrix.h"

namespace kerf::linear {
namespace {

// Returns 1 for the components that row i of A couples with other vertices, 0 for the others.
Eigen::Vector3d coupled(const BlockMatrix& A, int i) {
  Eigen::Vector3d sizes = Eigen::Vector3d::Zero();
  for (int at = A.row_begin(i); at < A.row_end(i); ++at) {
    if (A.column(at) != i) sizes += A.block(at).cwiseAbs().rowwise().sum();
  }
  return (sizes.array() > 0.0).cast<double>();
}

}  // namespace

void MultigridPreconditioner::analyse(const BlockMatrix& A) {
  const std::size_t n = as_index(A.num_rows());
  frames_.assign(n, Eigen::Matrix3d::Identity());
  positions_ = Eigen::Matrix3Xd::Zero(3, A.num_rows());
  aggregates_.find(A);
  set_coarse_pattern(A);
  set_lower_pattern(A);
  inverse_.assign(n, Block4f::Zero());
  modes_.assign(n, Modes::Zero());
  for (std::vector<Column4f>* vector : {&z_, &sum_}) vector->assign(n, Column4f::Zero());
  body_.assign(as_index(aggregates_.size()), Body::Zero());
  coarse_b_ = Eigen::Matrix3Xd::Zero(3, 2 * aggregates_.size());
}

// Couples two aggregates if a block of A couples a vertex of one with a vertex of the other.
void MultigridPreconditioner::set_coarse_pattern(const BlockMatrix& A) {
  coarse_ = {};
  coarse_.resize(2 * aggregates_.size());
  std::vector<int> neighbours;
  std::vector<int> columns;
  std::vector<int> seen(as_index(aggregates_.size()), -1);
  for (int g = 0; g < aggregates_.size(); ++g) {
    neighbours.clear();
    for (const int i : aggregates_.members(g)) {
      for (int at = A.row_begin(i); at < A.row_end(i); ++at) {
        const int other = aggregates_.of(A.column(at));
        if (seen[as_index(other)] == g) continue;
        seen[as_index(other)] = g;
        neighbours.push_back(other);
      }
    }
    std::sort(neighbours.begin(), neighbours.end());
    columns.clear();
    for (const int other : neighbours) columns.insert(columns.end(), {2 * other, 2 * other + 1});
    coarse_.set_row(2 * g, columns);
    coarse_.set_row(2 * g + 1, columns);
  }
  if (aggregates_.size() > 0) factor_.analyse(coarse_);
}

int MultigridPreconditioner::coarse_place(int row, int column) const {
  return coarse_.find(2 * row, 2 * column) - coarse_.row_begin(2 * row);
}

void MultigridPreconditioner::set_lower_pattern(const BlockMatrix& A) {
  lower_begin_.assign(1, 0);
  lower_column_.clear();
  upper_begin_.assign(1, 0);
  upper_column_.clear();
  link_begin_.assign(1, 0);
  links_.clear();
  link_of_.assign(as_index(aggregates_.size()), -1);
  std::size_t most = 0;
  for (int i = 0; i < A.num_rows(); ++i) {
    const std::size_t first = links_.size();
    for (int at = A.row_begin(i); at < A.row_end(i); ++at) {
      const int j = A.column(at);
      if (j > i) upper_column_.push_back(j);
      if (j >= i) continue;
      lower_column_.push_back(j);
      const int g = aggregates_.of(j);
      const bool is_known = std::any_of(links_.begin() + static_cast<std::ptrdiff_t>(first), links_.end(),
                                        [g](const Link& link) { return link.aggregate == g; });
      const int own = aggregates_.of(i);
      if (!is_known) links_.push_back({g, coarse_place(own, g), coarse_place(g, own)});
    }
    lower_begin_.push_back(static_cast<int>(lower_column_.size()));
    upper_begin_.push_back(static_cast<int>(upper_column_.size()));
    link_begin_.push_back(static_cast<int>(links_.size()));
    most = std::max(most, links_.size() - first);
  }
  lower_.assign(lower_column_.size(), Block4f::Zero());
  upper_.assign(upper_column_.size(), Block4f::Zero());
  linked_.assign(links_.size(), Modes4f::Zero());
  row_.resize(most);
}

bool MultigridPreconditioner::prepare(const BlockMatrix& A) {
  find_modes(A);
  coarse_.set_zero();
  if (!load_rows(A)) return false;
  if (aggregates_.size() == 0) return true;
  // Gives missing motions of an aggregate, whose modes are 0, a diagonal of 1.
  for (int i = 0; i < coarse_.num_rows(); ++i) {
    for (double& entry : coarse_.block(coarse_.diagonal(i)).diagonal()) {
      if (!(entry > 0.0)) entry = 1.0;
    }
  }
  PivotRule<float> rule;
  rule.replaces = true;  // any positive definite factor will do
  return factor_.factorise(coarse_, {}, rule);
}

// Sets modes_ to translations along the frame of the root and rotations about its axes, orthonormalised within an
// aggregate (Gram-Schmidt). Modes that an aggregate does not have, as when its vertices are in a line, become 0.
void MultigridPreconditioner::find_modes(const BlockMatrix& A) {
  constexpr double kGone = 1e-18;  // bound of the squared norm of a missing mode
  for (int g = 0; g < aggregates_.size(); ++g) {
    const std::span<const int> members = aggregates_.members(g);
    const int root = aggregates_.root(g);
    const Eigen::Matrix3d& axes = frames_[as_index(root)];
    for (const int i : members) {
      const Eigen::Matrix3d to_frame = frames_[as_index(i)].transpose() * coupled(A, i).asDiagonal();
      modes_[as_index(i)].leftCols<3>() = to_frame * axes;
      modes_[as_index(i)].rightCols<3>() = to_frame * cross_matrix(positions_.col(root) - positions_.col(i)) * axes;
    }
    for (int k = 0; k < kModes; ++k) {
      double before = 0.0;
      for (const int i : members) before += modes_[as_index(i)].col(k).squaredNorm();
      for (int l = 0; l < k; ++l) {
        double product = 0.0;
        for (const int i : members) product += modes_[as_index(i)].col(l).dot(modes_[as_index(i)].col(k));
        for (const int i : members) modes_[as_index(i)].col(k) -= product * modes_[as_index(i)].col(l);
      }
      double after = 0.0;
      for (const int i : members) after += modes_[as_index(i)].col(k).squaredNorm();
      const double scale = after > kGone * before ? 1.0 / std::sqrt(after) : 0.0;
      for (const int i : members) modes_[as_index(i)].col(k) *= scale;
    }
  }
}

// Sets lower_, upper_, inverse_, linked_ and coarse_ = P^T (L P) + (P^T (L P))^T + P^T D P, with D the diagonal blocks.
// The sums of coarse_ are in double, because large stretching terms cancel in motions that only bend. Returns false if
// a diagonal block is not positive definite.
bool MultigridPreconditioner::load_rows(const BlockMatrix& A) {
  for (int i = 0; i < A.num_rows(); ++i) {
    const Eigen::Matrix3d to_frame = frames_[as_index(i)].transpose();
    const int links_end = link_begin_[as_index(i) + 1];
    for (int k = link_begin_[as_index(i)]; k < links_end; ++k) {
      link_of_[as_index(links_[as_index(k)].aggregate)] = k - link_begin_[as_index(i)];
      row_[as_index(k - link_begin_[as_index(i)])].setZero();
    }
    int at = A.row_begin(i);
    for (int k = lower_begin_[as_index(i)]; k < lower_begin_[as_index(i) + 1]; ++k, ++at) {
      const int j = lower_column_[as_index(k)];
      const Eigen::Matrix3d block = to_frame * A.block(at) * frames_[as_index(j)];
      lower_[as_index(k)].topRows<3>() = block.cast<float>();
      row_[as_index(link_of_[as_index(aggregates_.of(j))])].noalias() += block * modes_[as_index(j)];
    }
    const Eigen::Matrix3d diagonal = to_frame * A.block(at) * frames_[as_index(i)];
    const Eigen::LLT<Eigen::Matrix3d> factor(diagonal);
    if (factor.info() != Eigen::Success) return false;
    inverse_[as_index(i)].topRows<3>() = factor.solve(Eigen::Matrix3d::Identity()).cast<float>();
    ++at;
    for (int k = upper_begin_[as_index(i)]; k < upper_begin_[as_index(i) + 1]; ++k, ++at) {
      upper_[as_index(k)].topRows<3>() =
          (to_frame * A.block(at) * frames_[as_index(upper_column_[as_index(k)])]).cast<float>();
    }
    const int own = aggregates_.of(i);
    if (own < 0) continue;
    const Modes& modes = modes_[as_index(i)];
    add_to_coarse(own, coarse_place(own, own), modes.transpose() * diagonal * modes);
    for (int k = link_begin_[as_index(i)]; k < links_end; ++k) {
      const Modes& linked = row_[as_index(k - link_begin_[as_index(i)])];
      linked_[as_index(k)].topRows<3>() = linked.cast<float>();
      const Eigen::Matrix<double, kModes, kModes> X = modes.transpose() * linked;
      add_to_coarse(own, links_[as_index(k)].row, X);
      add_to_coarse(links_[as_index(k)].aggregate, links_[as_index(k)].column, X.transpose());
    }
  }
  return true;
}

void MultigridPreconditioner::add_to_coarse(int row, int place, const Eigen::Matrix<double, kModes, kModes>& X) {
  for (int k = 0; k < 2; ++k) {
    const int at = coarse_.row_begin(2 * row + k) + place;
    coarse_.block(at) += X.block<3, 3>(3 * k, 0);
    coarse_.block(at + 1) += X.block<3, 3>(3 * k, 3);
  }
}

void MultigridPreconditioner::apply(const VertexField& r, VertexField& z) {
  const double largest = r.cwiseAbs().maxCoeff();
  if (!(largest > 0.0)) {
    z = r;
    return;
  }
  const double scale = 1.0 / largest;  // keeps values within the range of floats
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    sum_[i].head<3>() = (frames_[i].transpose() * (scale * r.col(static_cast<Eigen::Index>(i)))).cast<float>();
  }
  sweep_forward();
  if (aggregates_.size() > 0) correct_bodies();
  sweep_backward();
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    z.col(static_cast<Eigen::Index>(i)) = frames_[i] * (largest * z_[i].head<3>().cast<double>());
  }
}

// Solves (D + L) z = r and sets body_ to P^T (r - A z), where r - A z = -L^T z.
void MultigridPreconditioner::sweep_forward() {
  for (Body& body : body_) body.setZero();
  for (std::size_t i = 0; i < z_.size(); ++i) {
    Column4f sum = sum_[i];
    for (int k = lower_begin_[i]; k < lower_begin_[i + 1]; ++k) {
      sum.noalias() -= lower_[as_index(k)] * z_[as_index(lower_column_[as_index(k)])].head<3>();
    }
    sum_[i] = sum;
    const Column4f z = inverse_[i] * sum.head<3>();
    z_[i] = z;
    for (int k = link_begin_[i]; k < link_begin_[i + 1]; ++k) {
      body_[as_index(links_[as_index(k)].aggregate)].noalias() -= linked_[as_index(k)].transpose() * z;
    }
  }
}

void MultigridPreconditioner::correct_bodies() {
  for (std::size_t g = 0; g < body_.size(); ++g) {
    const auto column = static_cast<Eigen::Index>(2 * g);
    coarse_b_.col(column) = body_[g].head<3>().cast<double>();
    coarse_b_.col(column + 1) = body_[g].tail<3>().cast<double>();
  }
  factor_.solve(coarse_b_, coarse_b_);
  for (std::size_t g = 0; g < body_.size(); ++g) {
    const auto column = static_cast<Eigen::Index>(2 * g);
    body_[g].head<3>() = coarse_b_.col(column).cast<float>();
    body_[g].tail<3>() = coarse_b_.col(column + 1).cast<float>();
  }
}

// Solves (D + L^T) z = r - L (z + P e), where e is the correction of bodies.
void MultigridPreconditioner::sweep_backward() {
  for (std::size_t i = z_.size(); i-- > 0;) {
    Column4f sum = sum_[i];  // r - L z
    for (int k = link_begin_[i]; k < link_begin_[i + 1]; ++k) {
      sum.noalias() -= linked_[as_index(k)] * body_[as_index(links_[as_index(k)].aggregate)];
    }
    // Reads memory in order and uses the most recent result last.
    for (int k = upper_begin_[i + 1]; k-- > upper_begin_[i];) {
      sum.noalias() -= upper_[as_index(k)] * z_[as_index(upper_column_[as_index(k)])].head<3>();
    }
    z_[i].noalias() = inverse_[i] * sum.head<3>();
  }
}

}  // namespace kerf::linear
