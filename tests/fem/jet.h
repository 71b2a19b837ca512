#pragma once

#include <cmath>

#include <Eigen/Core>

namespace kerf::fem {

// Holds a function of N variables at one place with its first and second derivatives, by forward differentiation
// (Griewank and Walther 2008, "Evaluating Derivatives", chapter 3). It is exact up to the rounding of long double,
// without a step whose size must suit a mesh.
template <int N>
struct Jet {
  using Gradient = Eigen::Matrix<long double, N, 1>;
  using Hessian = Eigen::Matrix<long double, N, N>;

  long double value = 0.0L;
  Gradient gradient = Gradient::Zero();
  Hessian hessian = Hessian::Zero();

  static Jet variable(long double value, int index) {
    Jet made;
    made.value = value;
    made.gradient[index] = 1.0L;
    return made;
  }
  // f of a jet, from f, f' and f'' at its value.
  [[nodiscard]] Jet through(long double f, long double slope, long double curvature) const {
    Jet made;
    made.value = f;
    made.gradient = slope * gradient;
    made.hessian = slope * hessian + curvature * (gradient * gradient.transpose());
    return made;
  }

  friend Jet operator+(const Jet& a, const Jet& b) {
    Jet sum;
    sum.value = a.value + b.value;
    sum.gradient = a.gradient + b.gradient;
    sum.hessian = a.hessian + b.hessian;
    return sum;
  }
  friend Jet operator-(const Jet& a, const Jet& b) { return a + -1.0L * b; }
  friend Jet operator+(Jet a, long double b) {
    a.value += b;
    return a;
  }
  friend Jet operator-(const Jet& a, long double b) { return a + -b; }
  friend Jet operator*(long double a, const Jet& b) { return b.through(a * b.value, a, 0.0L); }
  friend Jet operator*(const Jet& a, const Jet& b) {
    Jet product;
    product.value = a.value * b.value;
    product.gradient = a.value * b.gradient + b.value * a.gradient;
    product.hessian = a.value * b.hessian + b.value * a.hessian + a.gradient * b.gradient.transpose() +
                      b.gradient * a.gradient.transpose();
    return product;
  }
  friend Jet operator/(const Jet& a, const Jet& b) {
    const long double inverse = 1.0L / b.value;
    return a * b.through(inverse, -inverse * inverse, 2.0L * inverse * inverse * inverse);
  }
};

// Requires a positive value.
template <int N>
Jet<N> sqrt(const Jet<N>& a) {
  const long double root = std::sqrt(a.value);
  return a.through(root, 0.5L / root, -0.25L / (root * a.value));
}

// Requires that not both are 0.
template <int N>
Jet<N> atan2(const Jet<N>& y, const Jet<N>& x) {
  const long double squared = x.value * x.value + y.value * y.value;
  const long double by_y = x.value / squared;
  const long double by_x = -y.value / squared;
  Jet<N> made;
  made.value = std::atan2(y.value, x.value);
  made.gradient = by_y * y.gradient + by_x * x.gradient;
  const typename Jet<N>::Hessian mixed = y.gradient * x.gradient.transpose();
  made.hessian = by_y * y.hessian + by_x * x.hessian +
                 2.0L * by_y * by_x * (y.gradient * y.gradient.transpose() - x.gradient * x.gradient.transpose()) +
                 (by_x * by_x - by_y * by_y) * (mixed + mixed.transpose());
  return made;
}

}  // namespace kerf::fem
