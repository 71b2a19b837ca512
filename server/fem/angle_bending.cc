#include "server/fem/angle_bending.h"

#include <algorithm>

#include "server/fem/block_matrix.h"

namespace kerf::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using mesh::VertexField;
using mesh::VertexId;

Hinge hinge_at(const AngleBending::Fold& fold, const VertexField& x) {
  std::array<Vector3d, 4> at;
  for (std::size_t i = 0; i < 3; ++i) at[i] = x.col(fold.vertex[i]);
  at[3] = fold.vertex[3] == mesh::kNone ? Vector3d(0.5 * (at[0] + at[1]) + fold.held) : Vector3d(x.col(fold.vertex[3]));
  return {at, fold.rest};
}

// Of a hinge by its vertices alone: what is held moves with the middle of the edge.
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

// A sum of gradients of folds, by vertex.
class GradientSum {
 public:
  void add(double factor, const AngleBending::Fold& fold, const std::array<Vector3d, 4>& gradient) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (fold.vertex[i] != mesh::kNone) at(fold.vertex[i]) += factor * gradient[i];
    }
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] VertexId vertex(std::size_t i) const { return vertices_[i]; }
  [[nodiscard]] const Vector3d& value(std::size_t i) const { return values_[i]; }

 private:
  Vector3d& at(VertexId vertex) {
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
  std::array<Vector3d, 8> values_;
};

// K += a b^T + b a^T, of sums over the same folds.
void add_products(const GradientSum& a, const GradientSum& b, BlockMatrix& matrix) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < a.size(); ++j) {
      matrix.block(matrix.find(a.vertex(i), a.vertex(j))) +=
          a.value(i) * b.value(j).transpose() + b.value(i) * a.value(j).transpose();
    }
  }
}

// K += a b^T
void add_product(const GradientSum& a, const GradientSum& b, BlockMatrix& matrix) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      matrix.block(matrix.find(a.vertex(i), b.vertex(j))) += a.value(i) * b.value(j).transpose();
    }
  }
}

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
  std::vector<double> theta;
  std::vector<std::array<Vector3d, 4>> gradients;
  theta.reserve(folds.size());
  gradients.reserve(folds.size());
  for (const Fold& fold : folds) {
    const Hinge hinge = hinge_at(fold, x);
    theta.push_back(hinge.theta());
    gradients.push_back(gradient_of(fold, hinge));
  }
  const std::vector<double> moment = moments_at(theta);
  for (std::size_t e = 0; e < folds.size(); ++e) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (folds[e].vertex[i] != mesh::kNone) f.col(folds[e].vertex[i]) -= moment[e] * gradients[e][i];
    }
  }
}

std::vector<double> AngleBending::predicted_moments(const VertexField& x, const VertexField& step) const {
  std::vector<double> theta;
  theta.reserve(folds.size());
  for (const Fold& fold : folds) {
    const Hinge hinge = hinge_at(fold, x);
    const std::array<Vector3d, 4> gradient = gradient_of(fold, hinge);
    double then = hinge.theta();
    for (std::size_t i = 0; i < 4; ++i) {
      if (fold.vertex[i] != mesh::kNone) then += gradient[i].dot(step.col(fold.vertex[i]));
    }
    theta.push_back(then);
  }
  return moments_at(theta);
}

void AngleBending::add_stiffness(const VertexField& x, std::span<const double> moments, bool project,
                                 BlockMatrix& matrix) const {
  std::vector<double> theta;
  std::vector<std::array<Vector3d, 4>> gradients;
  std::vector<Hinge> hinges;
  theta.reserve(folds.size());
  gradients.reserve(folds.size());
  hinges.reserve(folds.size());
  for (const Fold& fold : folds) {
    hinges.push_back(hinge_at(fold, x));
    theta.push_back(hinges.back().theta());
    gradients.push_back(gradient_of(fold, hinges.back()));
  }
  for (const Patch& patch : patches) {
    for (std::size_t r = 0; r < 3; ++r) {
      if (patch.fold[r] < 0) continue;
      const auto own = static_cast<std::size_t>(patch.fold[r]);
      GradientSum by_row;
      GradientSum weighed;
      by_row.add(1.0, folds[own], gradients[own]);
      for (std::size_t s = 0; s < 3; ++s) {
        if (patch.fold[s] < 0) continue;
        const auto other = static_cast<std::size_t>(patch.fold[s]);
        weighed.add(patch.stiffness(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(s)), folds[other],
                    gradients[other]);
      }
      add_product(by_row, weighed, matrix);
    }
  }
  for (const Kink& edge : kinks) {
    GradientSum kink;
    GradientSum load;
    for (std::size_t i = 0; i < edge.fold.size() && edge.fold[i] >= 0; ++i) {
      const auto at = static_cast<std::size_t>(edge.fold[i]);
      kink.add(edge.kink[i], folds[at], gradients[at]);
      load.add(edge.load[i], folds[at], gradients[at]);
    }
    add_products(kink, load, matrix);
  }
  if (project) return;
  std::vector<double> at_x;
  if (moments.empty()) {
    at_x = moments_at(theta);
    moments = at_x;
  }
  for (std::size_t e = 0; e < folds.size(); ++e) {
    if (moments[e] == 0.0) continue;
    const Eigen::Matrix<double, 12, 12> turn = moments[e] * hessian_of(folds[e], hinges[e]);
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
