#include "server/core/cut/rational_piece.h"

#include <algorithm>
#include <cmath>

#include "server/core/cut/segment_distance.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMaxCoefficients = 6;  // coefficients of a derivative's numerator of degree 2 * 3 - 1
constexpr int kMaxSearched = 256;    // most intervals searched for the sign changes of one polynomial
// -; length of the parameter interval at which the search for a sign change stops. At a double root the derivative is
// then about the square of this length.
constexpr double kFinest = 1.0e-9;
// -; a derivative below this times its largest coefficient counts as zero. Rounding displaces double roots by about the
// square root of the machine's precision.
constexpr double kVanishing = 1.0e-7;

// Represents a polynomial on [0, 1] by its Bernstein coefficients, of which the first degree + 1 are in use.
struct Polynomial {
  int degree = 0;
  std::array<double, kMaxCoefficients> coefficients{};
};

// Binomial coefficients n over k, n <= 5.
constexpr std::array<std::array<double, 6>, 6> kBinomial{{
    {1, 0, 0, 0, 0, 0},
    {1, 1, 0, 0, 0, 0},
    {1, 2, 1, 0, 0, 0},
    {1, 3, 3, 1, 0, 0},
    {1, 4, 6, 4, 1, 0},
    {1, 5, 10, 10, 5, 1},
}};

double binomial(int n, int k) {
  return kBinomial[static_cast<std::size_t>(n)][static_cast<std::size_t>(k)];
}

Vector3d homogeneous(const Vector2d& point, double weight) {
  return {weight * point.x(), weight * point.y(), weight};
}

// Returns (x' W - x W') / n for a piece with numerator x, weight W and degree n. This is the derivative of x / W times
// W^2 / n, so it has the sign of the derivative. The product of Bernstein polynomials of degrees n - 1 and n has degree
// 2 n - 1.
Polynomial derivative_numerator(const RationalPiece& piece, int axis) {
  const int n = piece.degree;
  std::array<double, 4> x{};
  std::array<double, 4> w{};
  for (int i = 0; i <= n; ++i) {
    const Vector3d& point = piece.points[static_cast<std::size_t>(i)];
    w[static_cast<std::size_t>(i)] = point.z();
    // Measures from the start of the piece, so that a far origin cancels.
    x[static_cast<std::size_t>(i)] = point[axis] - point.z() * piece.start[axis];
  }
  x[0] = 0.0;
  Polynomial result;
  result.degree = 2 * n - 1;
  for (int i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double dx = x[at + 1] - x[at];
    const double dw = w[at + 1] - w[at];
    for (int j = 0; j <= n; ++j) {
      const auto other = static_cast<std::size_t>(j);
      const double scale = binomial(n - 1, i) * binomial(n, j) / binomial(result.degree, i + j);
      result.coefficients[static_cast<std::size_t>(i + j)] += scale * (dx * w[other] - x[other] * dw);
    }
  }
  return result;
}

std::pair<Polynomial, Polynomial> halves(const Polynomial& whole) {
  Polynomial left = whole;
  Polynomial right = whole;
  const auto degree = static_cast<std::size_t>(whole.degree);
  for (std::size_t level = 1; level <= degree; ++level) {
    for (std::size_t i = 0; i + level <= degree; ++i) {
      right.coefficients[i] = 0.5 * (right.coefficients[i] + right.coefficients[i + 1]);
    }
    left.coefficients[level] = right.coefficients[0];
  }
  return {left, right};
}

double value(const Polynomial& polynomial, double t) {
  std::array<double, kMaxCoefficients> c = polynomial.coefficients;
  for (int level = polynomial.degree; level > 0; --level) {
    for (int i = 0; i < level; ++i) {
      const auto at = static_cast<std::size_t>(i);
      c[at] = (1.0 - t) * c[at] + t * c[at + 1];
    }
  }
  return c[0];
}

double largest_coefficient(const Polynomial& polynomial) {
  double largest = 0.0;
  for (const double c : polynomial.coefficients) largest = std::max(largest, std::abs(c));
  return largest;
}

int sign_changes(const Polynomial& polynomial) {
  int changes = 0;
  double last = 0.0;
  for (int i = 0; i <= polynomial.degree; ++i) {
    const double c = polynomial.coefficients[static_cast<std::size_t>(i)];
    if (c == 0.0) continue;
    if (last * c < 0.0) ++changes;
    last = c > 0.0 ? 1.0 : -1.0;
  }
  return changes;
}

// Returns true if the coefficients prove that the polynomial is nowhere within `margin` of zero.
bool is_clear_of_zero(const Polynomial& polynomial, double margin) {
  const auto first = polynomial.coefficients.begin();
  const auto last = first + polynomial.degree + 1;
  return std::all_of(first, last, [margin](double c) { return c > margin; }) ||
         std::all_of(first, last, [margin](double c) { return c < -margin; });
}

// Returns the sorted parameters where the polynomial changes its sign and `other` may be within `margin` of zero.
// Intervals without a sign change among the coefficients have no root (Descartes' rule in Bernstein form); the others
// are halved down to kFinest. The number of intervals is limited, as a polynomial that is only rounding noise would
// need very many.
std::vector<double> sign_change_parameters(const Polynomial& polynomial, const Polynomial& other, double margin) {
  struct Interval {
    double from;
    double to;
    Polynomial on;
    Polynomial other;
  };
  std::vector<Interval> open{{0.0, 1.0, polynomial, other}};
  std::vector<double> found;
  for (int searched = 0; !open.empty() && searched < kMaxSearched; ++searched) {
    const Interval interval = open.back();
    open.pop_back();
    if (sign_changes(interval.on) == 0 || is_clear_of_zero(interval.other, margin)) continue;
    const double middle = 0.5 * (interval.from + interval.to);
    if (interval.to - interval.from < kFinest) {
      found.push_back(middle);
      continue;
    }
    const auto [left, right] = halves(interval.on);
    const auto [other_left, other_right] = halves(interval.other);
    // Adds a root exactly in the middle, which causes no sign change in either half.
    if (right.coefficients[0] == 0.0) found.push_back(middle);
    open.push_back({middle, interval.to, right, other_right});
    open.push_back({interval.from, middle, left, other_left});
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

RationalPiece piece_of(const Vector2d& start, const LineTo& line) {
  return {1, {homogeneous(start, 1.0), homogeneous(line.end, 1.0)}, start, line.end};
}

RationalPiece piece_of(const Vector2d& start, const QuadraticTo& quadratic) {
  const auto& w = quadratic.weights;
  return {2,
          {homogeneous(start, w[0]), homogeneous(quadratic.control, w[1]), homogeneous(quadratic.end, w[2])},
          start,
          quadratic.end};
}

RationalPiece piece_of(const Vector2d& start, const CubicTo& cubic) {
  const auto& w = cubic.weights;
  return {3,
          {homogeneous(start, w[0]), homogeneous(cubic.controls[0], w[1]), homogeneous(cubic.controls[1], w[2]),
           homogeneous(cubic.end, w[3])},
          start,
          cubic.end};
}

Vector2d projected(const Vector3d& homogeneous) {
  return homogeneous.head<2>() / homogeneous.z();
}

std::pair<RationalPiece, RationalPiece> split(const RationalPiece& piece, double t) {
  RationalPiece left = piece;
  RationalPiece right = piece;
  const double s = 1.0 - t;
  const auto degree = static_cast<std::size_t>(piece.degree);
  for (std::size_t level = 1; level <= degree; ++level) {
    for (std::size_t i = 0; i + level <= degree; ++i) {
      right.points[i] = (s * right.points[i] + t * right.points[i + 1]).eval();
    }
    left.points[level] = right.points[0];
  }
  left.end = right.start = projected(right.points[0]);
  return {left, right};
}

double balanced_parameter(const RationalPiece& piece) {
  const double ratio = piece.points[0].z() / piece.points[static_cast<std::size_t>(piece.degree)].z();
  // t / (1 - t) is the n-th root of the ratio. The cube root is replaced by the power 5/16, which takes square roots
  // only.
  const double fourth = std::sqrt(std::sqrt(ratio));
  const double root = piece.degree == 2 ? std::sqrt(ratio) : fourth * std::sqrt(std::sqrt(fourth));
  return std::clamp(root / (1.0 + root), 1.0e-3, 1.0 - 1.0e-3);
}

double deviation_bound(const RationalPiece& piece) {
  const auto degree = static_cast<std::size_t>(piece.degree);
  double farthest = 0.0;
  double inner = 0.0;
  for (std::size_t i = 1; i < degree; ++i) {
    farthest = std::max(farthest, distance_to_segment(projected(piece.points[i]), piece.start, piece.end));
    inner = std::max(inner, piece.points[i].z());
  }
  const double pull = piece.degree == 2 ? inner : 3.0 * inner;  // k W of the proof in the header
  return pull / (std::min(piece.points[0].z(), piece.points[degree].z()) + pull) * farthest;
}

std::vector<double> turning_parameters(const RationalPiece& piece, int axis) {
  return sign_change_parameters(derivative_numerator(piece, axis), Polynomial{}, 0.0);
}

std::vector<double> cusp_parameters(const RationalPiece& piece) {
  if (piece.degree == 1) return {};
  const std::array<Polynomial, 2> numerators{derivative_numerator(piece, 0), derivative_numerator(piece, 1)};
  const double vanishing =
      kVanishing * std::max(largest_coefficient(numerators[0]), largest_coefficient(numerators[1]));
  std::vector<double> found;
  for (const std::size_t axis : {0U, 1U}) {
    for (const double t : sign_change_parameters(numerators[axis], numerators[1 - axis], vanishing)) {
      const bool cusp =
          std::abs(value(numerators[0], t)) <= vanishing && std::abs(value(numerators[1], t)) <= vanishing;
      const bool new_one =
          std::none_of(found.begin(), found.end(), [t](double known) { return std::abs(t - known) < kVanishing; });
      if (cusp && new_one && t > 0.0 && t < 1.0) found.push_back(t);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace kerf::cut
