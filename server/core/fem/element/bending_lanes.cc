#include "server/core/fem/element/bending_lanes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/fem/element/bending_lanes.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::fem {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, linear::kBlockLanes>;
using V = hn::Vec<Tag>;
using V2 = std::array<V, 2>;
using V3 = std::array<V, 3>;
using Symmetric = std::array<V, 6>;  // upper triangle by rows
constexpr std::array<std::size_t, 3> kDiagonal{0, 3, 5};

HWY_INLINE V number(double value) {
  return hn::Set(Tag(), value);
}
HWY_INLINE V load(const PatchLanes::Value& from, std::size_t l) {
  return hn::Load(Tag(), &from.lane[l]);
}
template <std::size_t N>
HWY_INLINE std::array<V, N> load(const std::array<PatchLanes::Value, N>& from, std::size_t l) {
  std::array<V, N> values;
  for (std::size_t i = 0; i < N; ++i) values[i] = load(from[i], l);
  return values;
}
HWY_INLINE void store(V value, PatchLanes::Value& to, std::size_t l) {
  hn::Store(value, Tag(), &to.lane[l]);
}
template <std::size_t N>
HWY_INLINE void store(const std::array<V, N>& values, std::array<PatchLanes::Value, N>& to, std::size_t l) {
  for (std::size_t i = 0; i < N; ++i) store(values[i], to[i], l);
}

HWY_INLINE V2 minus(const V2& a, const V2& b) {
  return {a[0] - b[0], a[1] - b[1]};
}
HWY_INLINE V cross(const V2& a, const V2& b) {
  return a[0] * b[1] - a[1] * b[0];
}
HWY_INLINE V dot(const V2& a, const V2& b) {
  return a[0] * b[0] + a[1] * b[1];
}
HWY_INLINE V dot(const V3& a, const V3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
HWY_INLINE V3 times(const Symmetric& A, const V3& x) {
  return {dot(V3{A[0], A[1], A[2]}, x), dot(V3{A[1], A[3], A[4]}, x), dot(V3{A[2], A[4], A[5]}, x)};
}
// Returns the dot products of all pairs; those of (i, j) and (j, i) must be equal.
HWY_INLINE Symmetric products(const std::array<V3, 3>& a, const std::array<V3, 3>& b) {
  return {dot(a[0], b[0]), dot(a[0], b[1]), dot(a[0], b[2]), dot(a[1], b[1]), dot(a[1], b[2]), dot(a[2], b[2])};
}
HWY_INLINE V3 quadratic_terms(const V2& d) {
  const V half = number(0.5);
  return {half * d[0] * d[0], half * d[1] * d[1], half * d[0] * d[1]};
}

// Returns the cofactors of the first row.
HWY_INLINE V3 cofactors(const Symmetric& G) {
  return {G[3] * G[5] - G[4] * G[4], G[2] * G[4] - G[1] * G[5], G[1] * G[4] - G[2] * G[3]};
}
HWY_INLINE V determinant(const Symmetric& G) {
  return dot(V3{G[0], G[1], G[2]}, cofactors(G));
}
HWY_INLINE Symmetric inverse_of(const Symmetric& G) {
  const V3 c = cofactors(G);
  const V scale = number(1.0) / dot(V3{G[0], G[1], G[2]}, c);
  return {scale * c[0],
          scale * c[1],
          scale * c[2],
          scale * (G[0] * G[5] - G[2] * G[2]),
          scale * (G[1] * G[2] - G[0] * G[4]),
          scale * (G[0] * G[3] - G[1] * G[1])};
}

// Returns true if all eigenvalues are above kEigenvalueCutOff of the largest. An upper bound, at most a third above it
// if all are positive, takes the place of the largest. The bound is mean + sqrt(2) standard deviations (Wolkowicz and
// Styan 1980, "Bounds for eigenvalues using traces").
HWY_INLINE hn::Mask<Tag> is_regular(Symmetric gram) {
  const V third = number(1.0 / 3.0);
  const V mean = third * (gram[0] + gram[3] + gram[5]);
  const V squares = gram[0] * gram[0] + gram[3] * gram[3] + gram[5] * gram[5] +
                    number(2.0) * (gram[1] * gram[1] + gram[2] * gram[2] + gram[4] * gram[4]);
  const V variance = hn::Max(hn::Zero(Tag()), third * squares - mean * mean);
  const V cut = number(kEigenvalueCutOff) * (mean + hn::Sqrt(number(2.0) * variance));
  for (const std::size_t diagonal : kDiagonal) gram[diagonal] = gram[diagonal] - cut;
  const V zero = hn::Zero(Tag());
  return hn::And(hn::And(gram[0] > zero, gram[0] * gram[3] > gram[1] * gram[1]), determinant(gram) > zero);
}

// Sets the conditions. A quadratic form q and barycentrics lambda of a point X obey q(X) - sum_k lambda_k q(X_k) =
// -sum_{j<k} lambda_j lambda_k q(X_j - X_k). So -P is C, made of products of barycentrics, times the quadratic terms of
// the edges. The linear dependence of conditions follows from C alone, and stays the same when the patch is stretched.
HWY_NOINLINE void set_conditions(PatchLanes& lanes) {
  const V one = number(1.0);
  const V half = number(0.5);
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(Tag())) {
    const V2 e1 = load(lanes.edges[0], l);
    const V2 e2 = load(lanes.edges[1], l);
    const V scale = one / cross(e1, e2);
    const std::array<V3, 3> edge_terms{quadratic_terms(minus(e2, e1)), quadratic_terms(e2), quadratic_terms(e1)};
    std::array<V3, 3> C;      // unit rows
    std::array<V3, 3> terms;  // C times the terms of the edges
    std::array<V, 3> missing;
    for (std::size_t r = 0; r < 3; ++r) {
      const V2 d = load(lanes.across[r], l);
      const V kind = load(lanes.kind[r], l);
      const auto is_free = kind == number(static_cast<double>(PatchEdge::kFree));
      // For a clamped edge all terms are derivatives along its arm, in its middle.
      const auto is_clamped = kind == number(static_cast<double>(PatchEdge::kClamped));
      V3 lambda;
      lambda[1] = scale * cross(d, e2);
      lambda[2] = scale * cross(e1, d);
      lambda[0] = hn::IfThenZeroElse(is_clamped, one) - lambda[1] - lambda[2];
      V3 at;
      for (std::size_t k = 0; k < 3; ++k) {
        at[k] = hn::IfThenElse(is_clamped, number(k == r ? 0.0 : 0.5), half * lambda[k]);
      }
      const V3 pairs{lambda[1] * at[2] + at[1] * lambda[2], lambda[2] * at[0] + at[2] * lambda[0],
                     lambda[0] * at[1] + at[0] * lambda[1]};
      const V over_size = one / hn::IfThenElse(is_free, one, hn::Sqrt(dot(pairs, pairs)));
      for (std::size_t k = 0; k < 3; ++k) {
        C[r][k] = hn::IfThenZeroElse(is_free, over_size * pairs[k]);
        lambda[k] = hn::IfThenZeroElse(is_free, lambda[k]);
      }
      for (std::size_t m = 0; m < 3; ++m) {
        terms[r][m] = C[r][0] * edge_terms[0][m] + C[r][1] * edge_terms[1][m] + C[r][2] * edge_terms[2][m];
      }
      missing[r] = hn::IfThenElseZero(is_free, one);
      store(lambda, lanes.lambda[r], l);
      store(terms[r], lanes.terms[r], l);
      store(over_size, lanes.over_size[r], l);
    }
    const Symmetric D_inverse = load(lanes.D_inverse, l);
    Symmetric gram = products(C, C);
    Symmetric G = products(terms, {times(D_inverse, terms[0]), times(D_inverse, terms[1]), times(D_inverse, terms[2])});
    for (std::size_t r = 0; r < 3; ++r) {  // keeps the inverses finite; set_results() leaves out missing conditions
      gram[kDiagonal[r]] = gram[kDiagonal[r]] + missing[r];
      G[kDiagonal[r]] = G[kDiagonal[r]] + missing[r];
    }
    store(gram, lanes.gram, l);
    store(G, lanes.G, l);
    store(inverse_of(G), lanes.inverse, l);
    store(hn::IfThenElseZero(is_regular(gram), one), lanes.is_regular, l);
  }
}

// Returns the row vector `of_w` times the conditions: its coefficients by vertex.
HWY_INLINE std::array<V, 6> by_vertex(const V3& of_w, const std::array<V3, 3>& lambda) {
  std::array<V, 6> values;
  for (std::size_t i = 0; i < 3; ++i) {
    values[i] = hn::Zero(Tag()) - of_w[0] * lambda[0][i] - of_w[1] * lambda[1][i] - of_w[2] * lambda[2][i];
    values[3 + i] = of_w[i];
  }
  return values;
}

// Sets a side. `moments` holds the rows of the map D kappa = moments w.
HWY_INLINE void set_side(PatchLanes& lanes, std::size_t l, std::size_t edge, const std::array<V3, 3>& moments,
                         const std::array<V3, 3>& lambda, V over_doubled_area) {
  const std::array<V2, 3> corners{V2{hn::Zero(Tag()), hn::Zero(Tag())}, load(lanes.edges[0], l),
                                  load(lanes.edges[1], l)};
  const V2& a = corners[(edge + 1) % 3];
  const V2 b_a = minus(corners[(edge + 2) % 3], a);
  const V2 c_a = minus(corners[edge], a);
  const V length = hn::Sqrt(dot(b_a, b_a));
  const V over_length = number(1.0) / length;
  const V2 n{over_length * b_a[1], hn::Zero(Tag()) - over_length * b_a[0]};
  const V over_height = length * over_doubled_area;
  // Derivatives of the barycentrics along n, and the remainder of a quadratic about the middle of the edge.
  const V foot = over_length * over_length * dot(b_a, c_a);  // of the height, from a to b
  V3 rate;
  rate[edge] = hn::Zero(Tag()) - over_height;
  rate[(edge + 1) % 3] = (number(1.0) - foot) * over_height;
  rate[(edge + 2) % 3] = foot * over_height;
  const V half = number(0.5);
  const V3 at_ends = quadratic_terms({half * b_a[0], half * b_a[1]});
  const V3 at_corner = quadratic_terms({c_a[0] - half * b_a[0], c_a[1] - half * b_a[1]});
  V3 rest;
  for (std::size_t m = 0; m < 3; ++m) rest[m] = over_height * (at_corner[m] - at_ends[m]);
  const V3 nn{n[0] * n[0], n[1] * n[1], number(2.0) * n[0] * n[1]};
  const V3 kappa = times(load(lanes.D_inverse, l), rest);
  V3 slope_of_w, moment_of_w;
  for (std::size_t r = 0; r < 3; ++r) {
    const V3 column{moments[0][r], moments[1][r], moments[2][r]};
    slope_of_w[r] = dot(kappa, column);
    moment_of_w[r] = dot(nn, column);
  }
  std::array<V, 6> slope = by_vertex(slope_of_w, lambda);
  for (std::size_t i = 0; i < 3; ++i) slope[i] = slope[i] + rate[i];
  PatchLanes::Side& side = lanes.sides[edge];
  store(slope, side.slope, l);
  store(by_vertex(moment_of_w, lambda), side.moment, l);
  store(length, side.length, l);
  // A = l h / 2
  store(number(0.5 * kKinkPenalty) * length * over_height * dot(nn, times(load(lanes.D, l), nn)), side.penalty, l);
}

HWY_NOINLINE void set_results(PatchLanes& lanes) {
  for (std::size_t l = 0; l < linear::kBlockLanes; l += hn::Lanes(Tag())) {
    const V doubled_area = cross(load(lanes.edges[0], l), load(lanes.edges[1], l));
    const std::array<V3, 3> lambda{load(lanes.lambda[0], l), load(lanes.lambda[1], l), load(lanes.lambda[2], l)};
    const std::array<V3, 3> terms{load(lanes.terms[0], l), load(lanes.terms[1], l), load(lanes.terms[2], l)};
    V3 over_size = load(lanes.over_size, l);
    for (std::size_t r = 0; r < 3; ++r) {  // 0 for missing conditions, and thus for all results that they are a factor
                                           // of
      const auto is_free = load(lanes.kind[r], l) == number(static_cast<double>(PatchEdge::kFree));
      over_size[r] = hn::IfThenZeroElse(is_free, over_size[r]);
    }
    const Symmetric inverse = load(lanes.inverse, l);
    const V area = number(0.5) * doubled_area;
    Symmetric law;
    std::array<V3, 3> moments;
    std::size_t at = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = i; j < 3; ++j, ++at) law[at] = area * (over_size[i] * over_size[j]) * inverse[at];
      // P = -diag(size) C Phi.
      const V3 of_w = times(inverse, {terms[0][i], terms[1][i], terms[2][i]});
      for (std::size_t j = 0; j < 3; ++j) moments[i][j] = hn::Zero(Tag()) - of_w[j] * over_size[j];
    }
    store(law, lanes.law, l);

    std::array<V3, 3> L;  // by vertex: its column of the conditions
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t r = 0; r < 3; ++r) L[i][r] = hn::Zero(Tag()) - lambda[r][i];
    }
    at = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const V3 law_L = times(law, L[i]);
      for (std::size_t j = i; j < 3; ++j) store(dot(L[j], law_L), lanes.stiffness[at++], l);
      for (std::size_t r = 0; r < 3; ++r) store(law_L[r], lanes.stiffness[at++], l);
    }
    for (const V entry : law) store(entry, lanes.stiffness[at++], l);
    for (std::size_t edge = 0; edge < 3; ++edge) {
      set_side(lanes, l, edge, moments, lambda, number(1.0) / doubled_area);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kerf::fem
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace kerf::fem {
namespace {
HWY_EXPORT(set_conditions);
HWY_EXPORT(set_results);

void set_symmetric(const Eigen::Matrix3d& from, std::size_t lane, PatchLanes::Symmetric3& to) {
  std::size_t at = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) to[at++].lane[lane] = from(i, j);
  }
}
Eigen::Matrix3d symmetric(const PatchLanes::Symmetric3& from, std::size_t lane) {
  const auto at = [&](std::size_t i) { return from[i].lane[lane]; };
  return Eigen::Matrix3d{
      {at(0), at(1), at(2)},
      {at(1), at(3), at(4)},
      {at(2), at(4), at(5)},
  };
}

// Returns the pseudo-inverse of G, without the conditions that are nearly dependent on others. These are eigenvectors
// of their Gram matrix `gram`, of unit rows, with eigenvalues below the cut-off.
Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& G, const Eigen::Matrix3d& gram) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(gram);
  const Eigen::Vector3d& values = eigen.eigenvalues();  // ascending
  const int first = values[0] > kEigenvalueCutOff * values[2] ? 0 : values[1] > kEigenvalueCutOff * values[2] ? 1 : 2;
  const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> kept = eigen.eigenvectors().rightCols(3 - first);
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> projected = kept.transpose() * G * kept;
  return kept * projected.inverse() * kept.transpose();
}

}  // namespace

void PatchLanes::set(std::size_t lane, const PatchGeometry& patch, const Eigen::Matrix3d& law_D,
                     const Eigen::Matrix3d& law_D_inverse) {
  const auto set_vector = [lane](const Eigen::Vector2d& from, Vector2& to) {
    to[0].lane[lane] = from.x();
    to[1].lane[lane] = from.y();
  };
  for (std::size_t k = 0; k < 2; ++k) set_vector(patch.corners[k + 1] - patch.corners[0], edges[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    kind[k].lane[lane] = static_cast<double>(patch.edges[k]);
    if (patch.edges[k] == PatchEdge::kNeighbour) set_vector(patch.opposite[k] - patch.corners[0], across[k]);
    if (patch.edges[k] == PatchEdge::kClamped) set_vector(clamp_arm(patch.corners, k), across[k]);
  }
  set_symmetric(law_D, lane, D);
  set_symmetric(law_D_inverse, lane, D_inverse);
}

void PatchLanes::fit(std::size_t count) {
  HWY_DYNAMIC_DISPATCH(set_conditions)(*this);
  for (std::size_t lane = 0; lane < count; ++lane) {
    if (is_regular.lane[lane] == 0.0) {
      set_symmetric(pseudo_inverse(symmetric(G, lane), symmetric(gram, lane)), lane, inverse);
    }
  }
  HWY_DYNAMIC_DISPATCH(set_results)(*this);
}

BendingFit PatchLanes::fit_of(std::size_t lane) const {
  BendingFit made;
  for (int r = 0; r < 3; ++r) {
    const auto row = static_cast<std::size_t>(r);
    if (kind[row].lane[lane] == static_cast<double>(PatchEdge::kFree)) continue;
    for (int k = 0; k < 3; ++k) made.conditions(r, k) = -lambda[row][static_cast<std::size_t>(k)].lane[lane];
    made.conditions(r, 3 + r) = 1.0;
  }
  made.law = symmetric(law, lane);
  return made;
}

std::array<double, 21> PatchLanes::stiffness_of(std::size_t lane) const {
  std::array<double, 21> upper{};
  for (std::size_t i = 0; i < upper.size(); ++i) upper[i] = stiffness[i].lane[lane];
  return upper;
}

BendingSide PatchLanes::side_of(std::size_t lane, std::size_t edge) const {
  const Side& from = sides[edge];
  BendingSide side;
  for (std::size_t i = 0; i < 6; ++i) {
    side.slope[i] = from.slope[i].lane[lane];
    side.moment[i] = from.moment[i].lane[lane];
  }
  side.length = from.length.lane[lane];
  side.penalty = from.penalty.lane[lane];
  return side;
}

}  // namespace kerf::fem
#endif  // HWY_ONCE
