#include "tests/fem/element_reference.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/fem/jet.h"

namespace kerf::fem {
namespace {

constexpr double kRounding = 0x1p-53;

using Vector3 = Eigen::Matrix<long double, 3, 1>;
using Matrix32 = Eigen::Matrix<long double, 3, 2>;
using OfGradient = Jet<6>;  // variables: the columns of F
using JetVector = std::array<OfGradient, 3>;

OfGradient dot(const JetVector& a, const JetVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

JetVector cross(const JetVector& a, const JetVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// One triangle of a model at x.
struct Triangle {
  Triangle(const ElementBlock& block, std::size_t lane, const MaterialTable& materials, const linear::VertexField& x,
           double moved)
      : C(materials.of(block, lane).membrane),
        area(block.area[lane]),
        vertex{block.vertex[0][lane], block.vertex[1][lane], block.vertex[2][lane]} {
    g.col(1) << block.g1[0][lane], block.g1[1][lane];
    g.col(2) << block.g2[0][lane], block.g2[1][lane];
    g.col(0) = -g.col(1) - g.col(2);
    size = static_cast<double>(g.col(1).norm() + g.col(2).norm());
    F.setZero();
    delta = kRounding + moved * size;
    for (int k = 1; k < 3; ++k) {
      const Vector3 d =
          x.col(vertex[static_cast<std::size_t>(k)]).cast<long double>() - x.col(vertex[0]).cast<long double>();
      F += d * g.col(k).transpose();
      delta += kRounding * static_cast<double>(d.norm() * g.col(k).norm());
    }
    const long double d = F.col(0).cross(F.col(1)).norm();
    const long double trace = F.squaredNorm();
    const long double largest = 0.5L * (std::sqrt(trace + 2.0L * d) + std::sqrt(std::max(0.0L, trace - 2.0L * d)));
    smaller_stretch = largest > 0.0L ? static_cast<double>(d / largest) : 0.0;
  }

  // True if double precision distinguishes the smaller stretch from 0, and so does polar_decomposition().
  [[nodiscard]] bool is_resolved() const {
    return smaller_stretch > std::max(1e3 * delta, 1.001e-12 * static_cast<double>(F.norm()));
  }

  // W / A, N/m.
  [[nodiscard]] OfGradient density(MembraneLaw law) const {
    std::array<JetVector, 2> f;
    for (int i = 0; i < 6; ++i) {
      f[static_cast<std::size_t>(i / 3)][static_cast<std::size_t>(i % 3)] = OfGradient::variable(F(i % 3, i / 3), i);
    }
    const OfGradient c11 = dot(f[0], f[0]);
    const OfGradient c22 = dot(f[1], f[1]);
    const OfGradient c12 = dot(f[0], f[1]);
    JetVector e;
    if (law == MembraneLaw::kGreen) {
      e = {0.5L * (c11 - 1.0L), 0.5L * (c22 - 1.0L), c12};
    } else {
      const JetVector n = cross(f[0], f[1]);
      const OfGradient d = sqrt(dot(n, n));
      const OfGradient s = sqrt(c11 + c22 + 2.0L * d);
      e = {(c11 + d) / s - 1.0L, (c22 + d) / s - 1.0L, 2.0L * (c12 / s)};
    }
    OfGradient sum;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        sum = sum + 0.5L * static_cast<long double>(C(i, j)) *
                        (e[static_cast<std::size_t>(i)] * e[static_cast<std::size_t>(j)]);
      }
    }
    return sum;
  }

  const Eigen::Matrix3d& C;              // N/m
  double area;                           // m^2
  std::array<mesh::VertexId, 3> vertex;  //
  Eigen::Matrix<long double, 2, 3> g;    // 1/m, column k: gradient of corner k
  Matrix32 F;                            // -
  double size = 0.0;                     // 1/m; G
  double delta = 0.0;                    // -
  double smaller_stretch = 0.0;          // -
};

void add_noise(const Triangle& triangle, MembraneLaw law, Reference& sum) {
  const double C = triangle.C.norm();
  const auto F = static_cast<double>(triangle.F.norm());
  const double G = triangle.size;
  double energy = 0.0;
  double force = 0.0;
  double stiffness = 0.0;
  if (law == MembraneLaw::kGreen) {
    const double e = 0.5 * (1.0 + F * F);
    const double off = (1.0 + F) * triangle.delta;
    energy = (e + off) * off;
    force = (1.0 + F * F) * triangle.delta;
    stiffness = (1.0 + F * F) * (kRounding + triangle.delta);
  } else {
    const double e = F + std::sqrt(2.0);
    const double s = triangle.smaller_stretch;
    energy = (e + triangle.delta) * triangle.delta;
    force = (1.0 + e / s) * triangle.delta;
    stiffness = (1.0 + e / s) * (kRounding + triangle.delta / s);
  }
  sum.energy_noise += triangle.area * C * energy;
  for (const mesh::VertexId i : triangle.vertex) {
    sum.force_noise[i] += triangle.area * G * C * force;
    for (const mesh::VertexId j : triangle.vertex) {
      sum.stiffness_noise(i, j) += triangle.area * G * G * C * stiffness;
    }
  }
}

// The energy of a triangle collapsed to a line or a point, where d is 0: S = F^T F / s.
long double collapsed_density(const Triangle& triangle) {
  const Eigen::Matrix<long double, 2, 2> metric = triangle.F.transpose() * triangle.F;
  const long double s = std::sqrt(metric.trace());
  const long double scale = s > 0.0L ? 1.0L / s : 0.0L;
  const Vector3 e(scale * metric(0, 0) - 1.0L, scale * metric(1, 1) - 1.0L, 2.0L * scale * metric(0, 1));
  return 0.5L * e.dot(triangle.C.cast<long double>() * e);
}

void add_derivatives(const Triangle& triangle, const OfGradient& density, Reference& sum) {
  const auto area = static_cast<long double>(triangle.area);
  Matrix32 P;
  for (int i = 0; i < 6; ++i) P(i % 3, i / 3) = density.gradient[i];
  for (int i = 0; i < 3; ++i) {
    const mesh::VertexId vertex = triangle.vertex[static_cast<std::size_t>(i)];
    sum.forces.col(vertex) -= (area * (P * triangle.g.col(i))).cast<double>();
    for (int j = 0; j < 3; ++j) {
      Eigen::Matrix<long double, 3, 3> K = Eigen::Matrix<long double, 3, 3>::Zero();
      for (int p = 0; p < 2; ++p) {
        for (int q = 0; q < 2; ++q)
          K += triangle.g(p, i) * triangle.g(q, j) * density.hessian.block<3, 3>(3 * p, 3 * q);
      }
      sum.stiffness.block<3, 3>(3 * vertex, 3 * triangle.vertex[static_cast<std::size_t>(j)]) +=
          (area * K).cast<double>();
    }
  }
}

// E = 1/2 sum Q_ab x_a.x_b of one term of bending, the positions seen from the first vertex.
template <typename Entry>
void add_bending_term(std::span<const mesh::VertexId> vertices, const linear::VertexField& x, double moved,
                      const Entry& entry, Reference& sum) {
  const Vector3 origin = x.col(vertices[0]).cast<long double>();
  const auto seen = [&](mesh::VertexId v) { return Vector3(x.col(v).cast<long double>() - origin); };
  for (std::size_t a = 0; a < vertices.size(); ++a) {
    const mesh::VertexId i = vertices[a];
    if (i == mesh::kNone) continue;
    Vector3 pull = Vector3::Zero();
    for (std::size_t b = 0; b < vertices.size(); ++b) {
      const mesh::VertexId j = vertices[b];
      if (j == mesh::kNone) continue;
      const double Q = entry(a, b);
      const double apart = (x.col(i) - x.col(j)).norm() + static_cast<double>(seen(i).norm() + seen(j).norm());
      pull += static_cast<long double>(Q) * seen(j);
      sum.energy_noise += std::abs(Q) * apart * (kRounding * apart + moved);
      sum.force_noise[i] += std::abs(Q) * (kRounding * apart + moved);
      sum.stiffness_noise(i, j) += std::abs(Q) * kRounding;
      sum.force_bound[i] += std::abs(Q) * apart;
      sum.stiffness.block<3, 3>(3 * i, 3 * j).diagonal().array() += Q;
    }
    sum.energy += 0.5L * seen(i).dot(pull);
    sum.forces.col(i) -= pull.cast<double>();
  }
}

}  // namespace

Reference::Reference(Eigen::Index num_vertices)
    : forces(Eigen::Matrix3Xd::Zero(3, num_vertices)),
      stiffness(Eigen::MatrixXd::Zero(3 * num_vertices, 3 * num_vertices)),
      force_noise(Eigen::VectorXd::Zero(num_vertices)),
      balance_noise(Eigen::VectorXd::Zero(num_vertices)),
      stiffness_noise(Eigen::MatrixXd::Zero(num_vertices, num_vertices)),
      force_bound(Eigen::VectorXd::Zero(num_vertices)),
      is_smooth(static_cast<std::size_t>(num_vertices), true) {}

Reference membrane_reference(const Model& model, const linear::VertexField& x, double moved) {
  const MembraneLaw law = model.materials().membrane_law();
  Reference sum(x.cols());
  for (const ElementBlock& block : model.element_blocks()) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (block.area[lane] == 0.0) continue;
      const Triangle triangle(block, lane, model.materials(), x, moved);
      const auto F = static_cast<double>(triangle.F.norm());
      const double stress = triangle.C.norm() * (law == MembraneLaw::kGreen ? F * (1.0 + F * F) : F + 2.0);
      for (const mesh::VertexId i : triangle.vertex) sum.force_bound[i] += 3.0 * triangle.area * triangle.size * stress;
      if (law == MembraneLaw::kCorotational && !triangle.is_resolved()) {
        for (const mesh::VertexId i : triangle.vertex) sum.is_smooth[static_cast<std::size_t>(i)] = false;
        sum.energy += static_cast<long double>(triangle.area) * collapsed_density(triangle);
        const double off = triangle.smaller_stretch + triangle.delta;  // which collapsed_density leaves out
        sum.energy_noise += triangle.area * triangle.C.norm() * (F + 2.0 + off) * off;
        continue;
      }
      const OfGradient density = triangle.density(law);
      sum.energy += static_cast<long double>(triangle.area) * density.value;
      add_derivatives(triangle, density, sum);
      add_noise(triangle, law, sum);
    }
  }
  return sum;
}

Reference bending_reference(const Model& model, const linear::VertexField& x, double moved) {
  Reference sum(x.cols());
  const BendingTerms terms = model.bending().terms(model.element_blocks());
  for (std::size_t slot = 0; slot < terms.patches.size(); ++slot) {
    const BendingPatch& patch = terms.patches[slot];
    if (patch.vertex[0] == mesh::kNone) continue;
    const auto entry = [&](std::size_t a, std::size_t b) { return patch.at(static_cast<int>(a), static_cast<int>(b)); };
    add_bending_term(patch.vertex, x, moved, entry, sum);
    for (const BendingEdge& edge : terms.edges.row(static_cast<int>(slot))) {
      add_bending_term(
          edge.vertex, x, moved, [&](std::size_t a, std::size_t b) { return edge.at(a, b); }, sum);
    }
  }
  return sum;
}

double stiffness_terms(const ElementBlock& block, std::size_t lane, const MaterialTable& materials,
                       const linear::VertexField& x) {
  const Triangle triangle(block, lane, materials, x, 0.0);
  const auto F = static_cast<double>(triangle.F.norm());
  const double unit = triangle.area * triangle.size * triangle.size * triangle.C.norm();
  if (materials.membrane_law() == MembraneLaw::kGreen) return unit * (1.0 + F * F);
  const double e = F + std::sqrt(2.0);
  return unit * (1.0 + (triangle.is_resolved() ? e / triangle.smaller_stretch : e));
}

}  // namespace kerf::fem
