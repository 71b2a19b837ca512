#include "server/core/contact/orient3d.h"

#include <array>
#include <cstddef>
#include <utility>

namespace kerf::contact {
namespace {

// Two doubles whose sum is exact: the rounded one, and what rounding left.
struct Exact2 {
  double high = 0.0;
  double low = 0.0;
};

Exact2 exact_sum(double a, double b) {
  const double sum = a + b;
  const double b_share = sum - a;
  return {sum, (a - (sum - b_share)) + (b - b_share)};
}

Exact2 exact_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

// A sum of doubles without rounding. Its parts do not overlap, ascend in magnitude and are not zero, so the last one
// has the sign of the sum.
class ExactSum {
 public:
  void add(double value) {
    double carry = value;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const Exact2 sum = exact_sum(carry, parts_[i]);
      if (sum.low != 0.0) parts_[kept++] = sum.low;
      carry = sum.high;
    }
    if (carry != 0.0) parts_[kept++] = carry;
    size_ = kept;
  }
  void add_product(double a, double b) {
    const Exact2 product = exact_product(a, b);
    if (product.low != 0.0) add(product.low);
    if (product.high != 0.0) add(product.high);
  }
  [[nodiscard]] int sign() const {
    if (size_ == 0) return 0;
    return parts_[size_ - 1] > 0.0 ? 1 : -1;
  }

 private:
  static constexpr std::size_t kMostParts = 6 * 8 * 4;  // six products of three differences of two parts each
  std::array<double, kMostParts> parts_;
  std::size_t size_ = 0;
};

// Adds the product of three differences.
void add_triple(const Exact2& u, const Exact2& v, const Exact2& w, double sign, ExactSum& sum) {
  for (const double a : {u.low, u.high}) {
    for (const double b : {v.low, v.high}) {
      if (a == 0.0 || b == 0.0) continue;
      const Exact2 product = exact_product(sign * a, b);
      for (const double c : {w.low, w.high}) {
        if (c == 0.0) continue;
        sum.add_product(product.low, c);
        sum.add_product(product.high, c);
      }
    }
  }
}

}  // namespace

int orient3d_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d) {
  const auto difference = [&a](const Eigen::Vector3d& to) {
    return std::array{exact_sum(to.x(), -a.x()), exact_sum(to.y(), -a.y()), exact_sum(to.z(), -a.z())};
  };
  const auto u = difference(b), v = difference(c), w = difference(d);
  ExactSum sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    add_triple(u[j], v[k], w[i], 1.0, sum);
    add_triple(u[k], v[j], w[i], -1.0, sum);
  }
  return sum.sign();
}

}  // namespace kerf::contact
