#include "server/core/fem/element/angle_bending.h"

#include "server/core/linear/block_matrix.h"

namespace kerf::fem {
namespace {

using Eigen::Vector3d;
using linear::VertexField;
using mesh::VertexId;

Hinge hinge_at(const AngleBending::Fold& fold, const VertexField& x) {
  std::array<Vector3d, 4> at;
  for (std::size_t i = 0; i < 3; ++i) at[i] = x.col(fold.vertex[i]);
  at[3] = fold.vertex[3] == mesh::kNone ? Vector3d(0.5 * (at[0] + at[1]) + fold.held) : Vector3d(x.col(fold.vertex[3]));
  return {at, fold.rest};
}

// Returns the gradient of a hinge by its vertices. At a clamped edge it includes that of the held point, which moves
// with the middle of the edge.
std::array<Vector3d, 4> gradient_of(const AngleBending::Fold& fold, const Hinge& hinge) {
  std::array<Vector3d, 4> made = hinge.gradient();
  if (fold.vertex[3] != mesh::kNone) return made;
  for (std::size_t i = 0; i < 2; ++i) made[i] += 0.5 * made[3];
  made[3].setZero();
  return made;
}

Eigen::Matrix<double, 12, 12> hessian_of(const AngleBending::Fold& fold, const Hinge& hinge) {
  Eigen::Matrix<double, 12, 12> made = hinge.hessian();
  if (fold.vertex[3] != mesh::kNone) return made;
  for (const Eigen::Index i : {0, 3}) made.middleRows<3>(i) += 0.5 * made.middleRows<3>(9);
  for (const Eigen::Index i : {0, 3}) made.middleCols<3>(i) += 0.5 * made.middleCols<3>(9);
  made.middleRows<3>(9).setZero();
  made.middleCols<3>(9).setZero();
  return made;
}

// All folds at one state.
struct FoldStates {
  std::vector<Hinge> hinges;
  std::vector<double> theta;                       // rad
  std::vector<std::array<Vector3d, 4>> gradients;  // 1/m, from gradient_of()
};

FoldStates fold_states(const std::vector<AngleBending::Fold>& folds, const VertexField& x) {
  FoldStates made;
  made.hinges.reserve(folds.size());
  made.theta.reserve(folds.size());
  made.gradients.reserve(folds.size());
  for (const AngleBending::Fold& fold : folds) {
    made.hinges.push_back(hinge_at(fold, x));
    made.theta.push_back(made.hinges.back().theta());
    made.gradients.push_back(gradient_of(fold, made.hinges.back()));
  }
  return made;
}

// N weighted sums of gradients of folds, each with a vector for every vertex that occurs in one.
template <int N>
class GradientSums {
 public:
  void add(int sum, double factor, const AngleBending::Fold& fold, const std::array<Vector3d, 4>& gradient) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (fold.vertex[i] != mesh::kNone) at(fold.vertex[i]).col(sum) += factor * gradient[i];
    }
  }

  // Adds to the matrix the sum over r, s of law_rs (sum r) (sum s)^T; law is symmetric.
  void add_products(const Eigen::Matrix<double, N, N>& law, linear::BlockMatrix& matrix) const {
    for (std::size_t i = 0; i < size_; ++i) {
      const Sums weighed = values_[i] * law;
      for (std::size_t j = 0; j < size_; ++j) {
        matrix.block(matrix.find(vertices_[i], vertices_[j])) += weighed * values_[j].transpose();
      }
    }
  }

 private:
  using Sums = Eigen::Matrix<double, 3, N>;

  Sums& at(VertexId vertex) {
    std::size_t place = 0;
    while (place < size_ && vertices_[place] != vertex) ++place;
    if (place == size_) {
      vertices_[size_] = vertex;
      values_[size_++].setZero();
    }
    return values_[place];
  }

  std::size_t size_ = 0;
  std::array<VertexId, 8> vertices_{};  // of two patches
  std::array<Sums, 8> values_;
};

}  // namespace

void AngleBending::Kink::add(int at, double to_kink, double to_load) {
  if (at < 0) return;
  std::size_t place = 0;
  while (fold[place] != at && fold[place] >= 0) ++place;
  fold[place] = at;
  kink[place] += to_kink;
  load[place] += to_load;
}

std::vector<double> AngleBending::moments_at(const std::vector<double>& theta) const {
  std::vector<double> moments(folds.size(), 0.0);
  for (const Patch& patch : patches) {
    Vector3d bent = Vector3d::Zero();
    for (std::size_t r = 0; r < 3; ++r) {
      if (patch.fold[r] >= 0) bent[static_cast<Eigen::Index>(r)] = theta[static_cast<std::size_t>(patch.fold[r])];
    }
    const Vector3d moment = patch.stiffness * bent;
    for (std::size_t r = 0; r < 3; ++r) {
      if (patch.fold[r] >= 0) moments[static_cast<std::size_t>(patch.fold[r])] += moment[static_cast<Eigen::Index>(r)];
    }
  }
  for (const Kink& edge : kinks) {
    double kink = 0.0;
    double load = 0.0;
    for (std::size_t i = 0; i < edge.fold.size() && edge.fold[i] >= 0; ++i) {
      kink += edge.kink[i] * theta[static_cast<std::size_t>(edge.fold[i])];
      load += edge.load[i] * theta[static_cast<std::size_t>(edge.fold[i])];
    }
    for (std::size_t i = 0; i < edge.fold.size() && edge.fold[i] >= 0; ++i) {
      moments[static_cast<std::size_t>(edge.fold[i])] += kink * edge.load[i] + load * edge.kink[i];
    }
  }
  return moments;
}

double AngleBending::energy(const VertexField& x) const {
  std::vector<double> theta;
  theta.reserve(folds.size());
  for (const Fold& fold : folds) theta.push_back(hinge_at(fold, x).theta());
  const std::vector<double> moment = moments_at(theta);
  double sum = 0.0;
  for (std::size_t i = 0; i < theta.size(); ++i) sum += theta[i] * moment[i];
  return 0.5 * sum;
}

void AngleBending::add_forces(const VertexField& x, VertexField& f) const {
  const FoldStates now = fold_states(folds, x);
  const std::vector<double> moment = moments_at(now.theta);
  for (std::size_t e = 0; e < folds.size(); ++e) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (folds[e].vertex[i] != mesh::kNone) f.col(folds[e].vertex[i]) -= moment[e] * now.gradients[e][i];
    }
  }
}

std::vector<double> AngleBending::predicted_moments(const VertexField& x, const VertexField& step) const {
  FoldStates then = fold_states(folds, x);
  for (std::size_t e = 0; e < folds.size(); ++e) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (folds[e].vertex[i] != mesh::kNone) then.theta[e] += then.gradients[e][i].dot(step.col(folds[e].vertex[i]));
    }
  }
  return moments_at(then.theta);
}

void AngleBending::add_stiffness(const VertexField& x, std::span<const double> moments, bool project,
                                 linear::BlockMatrix& matrix) const {
  const FoldStates now = fold_states(folds, x);
  for (const Patch& patch : patches) {
    GradientSums<3> angles;
    for (int r = 0; r < 3; ++r) {
      const int fold = patch.fold[static_cast<std::size_t>(r)];
      if (fold < 0) continue;
      const auto at = static_cast<std::size_t>(fold);
      angles.add(r, 1.0, folds[at], now.gradients[at]);
    }
    angles.add_products(patch.stiffness, matrix);
  }
  const Eigen::Matrix2d kink_by_load{{0.0, 1.0}, {1.0, 0.0}};
  for (const Kink& edge : kinks) {
    GradientSums<2> kink_and_load;
    for (std::size_t i = 0; i < edge.fold.size() && edge.fold[i] >= 0; ++i) {
      const auto at = static_cast<std::size_t>(edge.fold[i]);
      kink_and_load.add(0, edge.kink[i], folds[at], now.gradients[at]);
      kink_and_load.add(1, edge.load[i], folds[at], now.gradients[at]);
    }
    kink_and_load.add_products(kink_by_load, matrix);
  }
  if (project) return;
  std::vector<double> at_x;
  if (moments.empty()) {
    at_x = moments_at(now.theta);
    moments = at_x;
  }
  for (std::size_t e = 0; e < folds.size(); ++e) {
    if (moments[e] == 0.0) continue;
    const Eigen::Matrix<double, 12, 12> turn = moments[e] * hessian_of(folds[e], now.hinges[e]);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        if (folds[e].vertex[i] == mesh::kNone || folds[e].vertex[j] == mesh::kNone) continue;
        matrix.block(matrix.find(folds[e].vertex[i], folds[e].vertex[j])) +=
            turn.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j));
      }
    }
  }
}

}  // namespace kerf::fem
