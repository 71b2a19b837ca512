// The part of element_reference.h that is of bending by angles.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "server/core/fem/element/angle_bending.h"
#include "server/core/fem/element/rest_bending.h"
#include "tests/fem/element_reference.h"
#include "tests/fem/jet.h"

namespace kerf::fem {
namespace {

constexpr double kRounding = 0x1p-53;
constexpr double kPi = std::numbers::pi;

using OfPoints = Jet<12>;  // variables: the four points
using JetVector = std::array<OfPoints, 3>;

OfPoints dot(const JetVector& a, const JetVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
JetVector cross(const JetVector& a, const JetVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
JetVector minus(const JetVector& a, const JetVector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// One hinge at x, with all that bounds its errors.
struct Fold {
  Fold(const AngleBending::Fold& fold, const linear::VertexField& x, double moved) : vertex(fold.vertex) {
    std::array<JetVector, 4> point;
    for (int i = 0; i < 12; ++i) {
      const long double value = x(i % 3, vertex[static_cast<std::size_t>(i / 3)]);
      point[static_cast<std::size_t>(i / 3)][static_cast<std::size_t>(i % 3)] = OfPoints::variable(value, i);
    }
    const JetVector edge = minus(point[1], point[0]);
    const std::array<JetVector, 2> corner{minus(point[2], point[0]), minus(point[3], point[0])};
    const std::array<JetVector, 2> normal{cross(edge, corner[0]), cross(corner[1], edge)};
    const OfPoints squared = dot(edge, edge);
    const auto length = static_cast<double>(std::sqrt(squared.value));
    const double least_length = kLeastArea * fold.rest.length;
    const double counted_length = std::max(length, least_length);
    is_smooth = length > least_length;
    bool has_planes = true;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto size = static_cast<double>(std::sqrt(dot(normal[k], normal[k]).value));
      const double arm = std::sqrt(static_cast<double>(dot(corner[k], corner[k]).value));
      const double least = kLeastArea * fold.rest.length * fold.rest.height[k];
      const double counted = std::max(size, least);
      is_smooth = is_smooth && size > least;
      has_planes = has_planes && size > 0.0;
      // A direction is off by 2 at most.
      const double turned =
          size > 0.0 ? std::min(2.0, (kRounding * length * arm + moved * (length + arm)) / size) : 2.0;
      const double weight = 1.0 + 2.0 * arm / counted_length;
      const double slope = weight * counted_length / counted * std::min(1.0, size / counted);
      const double off = turned + kRounding + moved / counted_length;
      angle_noise += turned;
      gradient_size += slope;
      gradient_bound += 2.0 * weight * counted_length / counted;
      gradient_noise += slope * off;
      const double curvature = slope * ((length + arm) / counted + 1.0 / counted_length);
      hessian_size += curvature;
      hessian_noise += curvature * off;
    }
    if (has_planes) {
      const OfPoints up = dot(normal[0], corner[1]);
      const OfPoints sine = length > 0.0 ? sqrt(squared) * up : up;
      theta = atan2(sine, dot(normal[0], normal[1]));
    }
    // At pi, on which side of it is for rounding to say.
    constexpr double kRoundings = 64.0;
    if (kPi - std::abs(static_cast<double>(theta.value)) < kRoundings * angle_noise) angle_noise = 2.0 * kPi;
    angle_noise = std::min(2.0 * kPi, angle_noise + kRounding * std::abs(static_cast<double>(theta.value)));
  }

  std::array<mesh::VertexId, 4> vertex;
  OfPoints theta;               // rad
  bool is_smooth = true;        // neither triangle and not the edge counts as collapsed
  double angle_noise = 0.0;     // rad
  double gradient_size = 0.0;   // 1/m, of the terms of a point's gradient
  double gradient_bound = 0.0;  // 1/m, whatever the triangles are
  double gradient_noise = 0.0;  // 1/m
  double hessian_size = 0.0;    // 1/m^2
  double hessian_noise = 0.0;   // 1/m^2
};

// E = 1/2 theta.law theta; `terms` sums the sizes of what a number of it is made of.
struct AngleLaw {
  explicit AngleLaw(const AngleBending& angles) {
    const auto n = static_cast<Eigen::Index>(angles.folds.size());
    law = terms = Eigen::MatrixXd::Zero(n, n);
    const auto add = [&](int r, int s, double value) {
      if (r < 0 || s < 0) return;
      law(r, s) += value;
      terms(r, s) += std::abs(value);
    };
    for (const AngleBending::Patch& patch : angles.patches) {
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t s = 0; s < 3; ++s) {
          add(patch.fold[r], patch.fold[s],
              patch.stiffness(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(s)));
        }
      }
    }
    for (const AngleBending::Kink& kink : angles.kinks) {
      for (std::size_t r = 0; r < kink.fold.size(); ++r) {
        for (std::size_t s = 0; s < kink.fold.size(); ++s) {
          add(kink.fold[r], kink.fold[s], kink.kink[r] * kink.load[s]);
          add(kink.fold[r], kink.fold[s], kink.load[r] * kink.kink[s]);
        }
      }
    }
  }
  Eigen::MatrixXd law;    // J
  Eigen::MatrixXd terms;  // J
};

// Both vertices of `i` of fold e and of `j` of fold f.
template <typename Add>
void for_blocks(const Fold& e, const Fold& f, const Add& add) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      add(e.vertex[i], f.vertex[j], static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j));
    }
  }
}

}  // namespace

Reference angle_reference(const Model& model, const linear::VertexField& x, double moved) {
  const AngleBending& angles = *model.bending().angles();
  Reference sum(x.cols());
  std::vector<Fold> folds;
  folds.reserve(angles.folds.size());
  for (const AngleBending::Fold& fold : angles.folds) folds.emplace_back(fold, x, moved);
  const AngleLaw law(angles);
  const auto n = static_cast<Eigen::Index>(folds.size());
  Eigen::Matrix<long double, Eigen::Dynamic, 1> theta(n);
  Eigen::VectorXd noise(n);
  for (Eigen::Index e = 0; e < n; ++e) {
    theta[e] = folds[static_cast<std::size_t>(e)].theta.value;
    noise[e] = folds[static_cast<std::size_t>(e)].angle_noise;
  }
  const Eigen::Matrix<long double, Eigen::Dynamic, 1> moment = law.law.cast<long double>() * theta;
  const Eigen::VectorXd size = theta.cast<double>().cwiseAbs() + noise;
  const Eigen::VectorXd moment_size = law.terms * size;
  const Eigen::VectorXd moment_noise = law.terms * noise;
  sum.energy = 0.5L * theta.dot(moment);
  sum.energy_noise = size.dot(moment_noise);
  const Eigen::VectorXd moment_bound = law.terms * Eigen::VectorXd::Constant(n, kPi);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Fold& e = folds[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < 4; ++k) {
      const mesh::VertexId v = e.vertex[k];
      const auto own = static_cast<Eigen::Index>(3 * k);
      sum.forces.col(v) -= (moment[i] * e.theta.gradient.segment<3>(own)).cast<double>();
      sum.force_bound[v] += moment_bound[i] * e.gradient_bound;
      sum.balance_noise[v] += moment_size[i] * e.gradient_noise;
      sum.force_noise[v] += moment_size[i] * e.gradient_noise + moment_noise[i] * e.gradient_size;
      if (!e.is_smooth) sum.is_smooth[static_cast<std::size_t>(v)] = false;
    }
    for_blocks(e, e, [&](mesh::VertexId v, mesh::VertexId w, Eigen::Index r, Eigen::Index s) {
      sum.stiffness.block<3, 3>(3 * v, 3 * w) += (moment[i] * e.theta.hessian.block<3, 3>(r, s)).cast<double>();
      sum.stiffness_noise(v, w) += moment_size[i] * e.hessian_noise + moment_noise[i] * e.hessian_size;
    });
    for (Eigen::Index j = 0; j < n; ++j) {
      if (law.terms(i, j) == 0.0) continue;
      const Fold& f = folds[static_cast<std::size_t>(j)];
      const auto value = static_cast<long double>(law.law(i, j));
      const double off = e.gradient_size * (f.gradient_noise + kRounding * f.gradient_size) +
                         e.gradient_noise * (f.gradient_size + f.gradient_noise);
      for_blocks(e, f, [&](mesh::VertexId v, mesh::VertexId w, Eigen::Index r, Eigen::Index s) {
        sum.stiffness.block<3, 3>(3 * v, 3 * w) +=
            (value * e.theta.gradient.segment<3>(r) * f.theta.gradient.segment<3>(s).transpose()).cast<double>();
        sum.stiffness_noise(v, w) += law.terms(i, j) * off;
      });
    }
  }
  return sum;
}

}  // namespace kerf::fem
