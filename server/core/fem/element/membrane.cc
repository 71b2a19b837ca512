#include "server/core/fem/element/membrane.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "server/core/fem/element/element_lanes.h"

namespace kerf::fem {
namespace {

// A number that is the same in all lanes.
struct Uniform {
  double value;
  double operator[](std::size_t /*lane*/) const { return value; }
};

// A general symmetric plane-stress law and damping time, s, by lane.
template <typename Number>
struct Law {
  Number C11, C22, C33, C12, C13, C23, beta;
};

Law<Uniform> law_of(const Eigen::Matrix3d& C, double beta) {
  return {{C(0, 0)}, {C(1, 1)}, {C(2, 2)}, {C(0, 1)}, {C(0, 2)}, {C(1, 2)}, {beta}};
}

Law<Lane> law_of_lanes(const ElementBlock& block, const MaterialTable& materials, std::span<const double> beta) {
  Law<Lane> law;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const Eigen::Matrix3d& C = materials.of(block, l).membrane;
    law.C11[l] = C(0, 0);
    law.C22[l] = C(1, 1);
    law.C33[l] = C(2, 2);
    law.C12[l] = C(0, 1);
    law.C13[l] = C(0, 2);
    law.C23[l] = C(1, 2);
    law.beta[l] = damping_of(beta, block.material[l]);
  }
  return law;
}

struct LaneStrain {
  Lane e1, e2, e3;
};

struct LaneStress {
  Lane sigma1, sigma2, sigma3;  // N/m
};

struct LaneForces {
  Lane3 corner1, corner2;  // N; corner 0 has minus their sum
};

// The triangles of a block at x under the co-rotational law; GreenTriangles has the same members for Green's. The force
// on a corner is -A [column1, column2] T g, with T = [[sigma1, sigma3 - a], [sigma3 + a, sigma2]] and a = skew().
class CorotationalTriangles {
 public:
  void set(const ElementBlock& block, const linear::VertexField& x) { frames_at(block, x, frames_); }
  void set_strain(LaneStrain& e) const {
    for (std::size_t l = 0; l < kLanes; ++l) {
      e.e1[l] = frames_.S11[l] - 1.0;
      e.e2[l] = frames_.S22[l] - 1.0;
      e.e3[l] = 2.0 * frames_.S12[l];
    }
  }
  // Adds beta dS/dt to e. M = R^T dF/dt = dS/dt + w S with the spin w = [[0, -omega], [omega, 0]]. Hence omega = (M21 -
  // M12) / tr S: the rate of a rigid rotation is exactly zero however the triangle is strained.
  template <typename Number>
  void add_strain_rate(const ElementBlock& block, const linear::VertexField& v, const Number& beta,
                       LaneStrain& e) const {
    LaneEdges dv;
    Lane3 f1;
    Lane3 f2;
    gather_edges(block, v, dv);
    multiply_by_dm_inverse(block, dv, f1, f2);
    const LaneFrames& frames = frames_;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double M11 = frames.R1[0][l] * f1[0][l] + frames.R1[1][l] * f1[1][l] + frames.R1[2][l] * f1[2][l];
      const double M21 = frames.R2[0][l] * f1[0][l] + frames.R2[1][l] * f1[1][l] + frames.R2[2][l] * f1[2][l];
      const double M12 = frames.R1[0][l] * f2[0][l] + frames.R1[1][l] * f2[1][l] + frames.R1[2][l] * f2[2][l];
      const double M22 = frames.R2[0][l] * f2[0][l] + frames.R2[1][l] * f2[1][l] + frames.R2[2][l] * f2[2][l];
      const double omega = (M21 - M12) * frames.inverse_trace[l];
      e.e1[l] += beta[l] * (M11 + omega * frames.S12[l]);
      e.e2[l] += beta[l] * (M22 - omega * frames.S12[l]);
      e.e3[l] += beta[l] * (M12 + M21 + omega * (frames.S22[l] - frames.S11[l]));
    }
  }
  [[nodiscard]] const Lane3& column1() const { return frames_.R1; }
  [[nodiscard]] const Lane3& column2() const { return frames_.R2; }
  [[nodiscard]] double skew(const LaneStress& stress, std::size_t l) const {
    return (frames_.S12[l] * (stress.sigma1[l] - stress.sigma2[l]) +
            stress.sigma3[l] * (frames_.S22[l] - frames_.S11[l])) *
           frames_.inverse_trace[l];
  }

 private:
  LaneFrames frames_;
};

class GreenTriangles {
 public:
  void set(const ElementBlock& block, const linear::VertexField& x) {
    LaneEdges dx;
    gather_edges(block, x, dx);
    multiply_by_dm_inverse(block, dx, f1_, f2_);
  }
  void set_strain(LaneStrain& e) const {
    for (std::size_t l = 0; l < kLanes; ++l) {
      e.e1[l] = 0.5 * (dot(f1_, f1_, l) - 1.0);
      e.e2[l] = 0.5 * (dot(f2_, f2_, l) - 1.0);
      e.e3[l] = dot(f1_, f2_, l);
    }
  }
  // Adds beta (F^T dF/dt + dF/dt^T F) / 2 to e.
  template <typename Number>
  void add_strain_rate(const ElementBlock& block, const linear::VertexField& v, const Number& beta,
                       LaneStrain& e) const {
    GreenTriangles rate;
    rate.set(block, v);
    for (std::size_t l = 0; l < kLanes; ++l) {
      e.e1[l] += beta[l] * dot(f1_, rate.f1_, l);
      e.e2[l] += beta[l] * dot(f2_, rate.f2_, l);
      e.e3[l] += beta[l] * (dot(f1_, rate.f2_, l) + dot(f2_, rate.f1_, l));
    }
  }
  [[nodiscard]] const Lane3& column1() const { return f1_; }
  [[nodiscard]] const Lane3& column2() const { return f2_; }
  [[nodiscard]] double skew(const LaneStress& /*stress*/, std::size_t /*l*/) const { return 0.0; }

 private:
  static double dot(const Lane3& a, const Lane3& b, std::size_t l) {
    return a[0][l] * b[0][l] + a[1][l] * b[1][l] + a[2][l] * b[2][l];
  }

  Lane3 f1_, f2_;  // columns of F
};

template <typename Number>
void set_stress(const Law<Number>& law, const LaneStrain& e, LaneStress& stress) {
  for (std::size_t l = 0; l < kLanes; ++l) {
    stress.sigma1[l] = law.C11[l] * e.e1[l] + law.C12[l] * e.e2[l] + law.C13[l] * e.e3[l];
    stress.sigma2[l] = law.C12[l] * e.e1[l] + law.C22[l] * e.e2[l] + law.C23[l] * e.e3[l];
    stress.sigma3[l] = law.C13[l] * e.e1[l] + law.C23[l] * e.e2[l] + law.C33[l] * e.e3[l];
  }
}

template <typename Triangles>
void corner_forces(const ElementBlock& block, const Triangles& triangles, const LaneStress& stress,
                   LaneForces& forces) {
  const Lane3& column1 = triangles.column1();
  const Lane3& column2 = triangles.column2();
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double a = triangles.skew(stress, l);
    const double minus_area = -block.area[l];
    for (std::size_t c = 0; c < 3; ++c) {
      const double P1 = minus_area * (column1[c][l] * stress.sigma1[l] + column2[c][l] * (stress.sigma3[l] + a));
      const double P2 = minus_area * (column1[c][l] * (stress.sigma3[l] - a) + column2[c][l] * stress.sigma2[l]);
      forces.corner1[c][l] = P1 * block.g1[0][l] + P2 * block.g1[1][l];
      forces.corner2[c][l] = P1 * block.g2[0][l] + P2 * block.g2[1][l];
    }
  }
}

void scatter(const ElementBlock& block, const LaneForces& forces, linear::VertexField& f) {
  double* data = f.data();
  for (std::size_t l = 0; l < kLanes; ++l) {
    double* f0 = data + 3 * static_cast<std::ptrdiff_t>(block.vertex[0][l]);
    double* f1 = data + 3 * static_cast<std::ptrdiff_t>(block.vertex[1][l]);
    double* f2 = data + 3 * static_cast<std::ptrdiff_t>(block.vertex[2][l]);
    for (std::size_t c = 0; c < 3; ++c) {
      f0[c] -= forces.corner1[c][l] + forces.corner2[c][l];
      f1[c] += forces.corner1[c][l];
      f2[c] += forces.corner2[c][l];
    }
  }
}

// Calls visit(law) with the law of the lanes of a block.
template <typename Visit>
void with_law(const ElementBlock& block, const MaterialTable& materials, std::span<const double> beta,
              const Visit& visit) {
  if (block.has_one_material()) {
    visit(law_of(materials.of(block, 0).membrane, damping_of(beta, block.material[0])));
  } else {
    visit(law_of_lanes(block, materials, beta));
  }
}

template <typename Triangles>
void add_forces(std::span<const ElementBlock> blocks, const MaterialTable& materials, std::span<const double> beta,
                const linear::VertexField& x, const linear::VertexField& v, linear::VertexField& f) {
  const bool is_damped = std::any_of(beta.begin(), beta.end(), [](double each) { return each > 0.0; });
  Triangles triangles;
  LaneStrain e;
  LaneStress stress;
  LaneForces forces;
  for (const ElementBlock& block : blocks) {
    triangles.set(block, x);
    triangles.set_strain(e);
    with_law(block, materials, beta, [&](const auto& law) {
      if (is_damped) triangles.add_strain_rate(block, v, law.beta, e);
      set_stress(law, e, stress);
    });
    corner_forces(block, triangles, stress, forces);
    scatter(block, forces, f);
  }
}

template <typename Triangles>
double energy_of(std::span<const ElementBlock> blocks, const MaterialTable& materials, const linear::VertexField& x) {
  double energy = 0.0;
  Triangles triangles;
  LaneStrain e;
  for (const ElementBlock& block : blocks) {
    triangles.set(block, x);
    triangles.set_strain(e);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (block.area[l] == 0.0) continue;
      const Eigen::Vector3d strain(e.e1[l], e.e2[l], e.e3[l]);
      energy += 0.5 * block.area[l] * strain.dot(materials.of(block, l).membrane * strain);
    }
  }
  return energy;
}

double larger_principal(double a11, double a22, double a12) {
  const double half = 0.5 * (a11 - a22);
  return 0.5 * (a11 + a22) + std::sqrt(half * half + a12 * a12);
}

}  // namespace

void repair_collapsed_lane(const Lane3& f1, const Lane3& f2, std::size_t lane, LaneFrames& frames) {
  const Eigen::Vector3d a(f1[0][lane], f1[1][lane], f1[2][lane]);
  const Eigen::Vector3d b(f2[0][lane], f2[1][lane], f2[2][lane]);
  const Eigen::Vector3d line = a.squaredNorm() >= b.squaredNorm() ? a : b;
  Eigen::Vector3d R1 = Eigen::Vector3d::UnitX();
  Eigen::Vector3d R2 = Eigen::Vector3d::UnitY();
  const double length = line.norm();
  frames.inverse_trace[lane] = 1.0;
  if (length > 1e-15) {
    // The normal is perpendicular to the line and to the first coordinate axis that is least aligned with it.
    int axis = 0;
    const Eigen::Vector3d size = line.cwiseAbs();
    if (size[1] < size[axis]) axis = 1;
    if (size[2] < size[axis]) axis = 2;
    const Eigen::Vector3d n = line.cross(Eigen::Vector3d::Unit(axis)).normalized();
    const double s = std::sqrt(a.squaredNorm() + b.squaredNorm());
    R1 = (a + b.cross(n)) / s;
    R2 = (b + n.cross(a)) / s;
    frames.inverse_trace[lane] = 1.0 / s;
  }
  for (int c = 0; c < 3; ++c) {
    frames.R1[static_cast<std::size_t>(c)][lane] = R1[c];
    frames.R2[static_cast<std::size_t>(c)][lane] = R2[c];
  }
  const double inverse_s = frames.inverse_trace[lane];
  frames.S11[lane] = a.squaredNorm() * inverse_s;
  frames.S22[lane] = b.squaredNorm() * inverse_s;
  frames.S12[lane] = a.dot(b) * inverse_s;
}

void add_membrane_forces(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                         std::span<const double> beta, const linear::VertexField& x, const linear::VertexField& v,
                         linear::VertexField& f) {
  if (materials.membrane_law() == MembraneLaw::kGreen) {
    add_forces<GreenTriangles>(blocks, materials, beta, x, v, f);
  } else {
    add_forces<CorotationalTriangles>(blocks, materials, beta, x, v, f);
  }
}

double membrane_energy(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                       const linear::VertexField& x) {
  return materials.membrane_law() == MembraneLaw::kGreen ? energy_of<GreenTriangles>(blocks, materials, x)
                                                         : energy_of<CorotationalTriangles>(blocks, materials, x);
}

GreenStretch green_stretch(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                           const linear::VertexField& x) {
  GreenStretch largest;
  GreenTriangles triangles;
  LaneStrain e;
  LaneStress stress;
  for (const ElementBlock& block : blocks) {
    triangles.set(block, x);
    triangles.set_strain(e);
    with_law(block, materials, {}, [&](const auto& law) { set_stress(law, e, stress); });
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (block.area[l] == 0.0) continue;
      const double stretch_squared = 1.0 + 2.0 * larger_principal(e.e1[l], e.e2[l], 0.5 * e.e3[l]);
      const double sigma = larger_principal(stress.sigma1[l], stress.sigma2[l], stress.sigma3[l]);
      const double tension = std::max(sigma, 0.0) / materials.of(block, l).least_membrane;
      largest.tension = std::max(largest.tension, tension);
      largest.stiffening = std::max(largest.stiffening, stretch_squared + tension);
    }
  }
  return largest;
}

// Principal stretches are (s +- q / s) / 2 with c = F^T F, s = tr S = sqrt(tr c + 2 det F) and q = sqrt((c11 - c22)^2 +
// 4 c12^2). The larger of their distances from 1 is |s / 2 - 1| + q / (2 s).
StrainExtent measure_strain(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                            const linear::VertexField& x) {
  constexpr double kTiny = 1e-150;
  StrainExtent extent;
  double area = 0.0;
  double area_beyond = 0.0;
  Lane strain;
  LaneEdges edges;
  Lane3 f1;
  Lane3 f2;
  for (const ElementBlock& block : blocks) {
    gather_edges(block, x, edges);
    multiply_by_dm_inverse(block, edges, f1, f2);
    for (std::size_t l = 0; l < kLanes; ++l) {
      const LaneMetric m = metric_of(f1, f2, l);
      const double s = std::sqrt(m.c11 + m.c22 + 2.0 * std::sqrt(m.d_squared));
      const double q = std::sqrt((m.c11 - m.c22) * (m.c11 - m.c22) + 4.0 * (m.c12 * m.c12));
      strain[l] = std::abs(0.5 * s - 1.0) + 0.5 * q / (s + kTiny);
    }
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (block.area[l] == 0.0) continue;
      area += block.area[l];
      if (strain[l] > materials.of(block, l).material.strain_limit) area_beyond += block.area[l];
      extent.largest = std::max(extent.largest, strain[l]);
    }
  }
  if (area > 0.0) extent.beyond_limit = area_beyond / area;
  return extent;
}

}  // namespace kerf::fem
