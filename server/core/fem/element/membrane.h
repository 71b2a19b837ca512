#pragma once

#include <span>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Linear triangle with the plane-stress law C of its material (N/m, Voigt (e11, e22, 2 e12), material axes). g_i is the
// gradient of the shape function of corner i. MaterialTable::membrane_law() chooses one of two strains. Co-rotational:
//   F = [x1 - x0, x2 - x0] Dm^-1 (3x2) = R S,  e = S - I,  sigma = C e,  W = A/2 e.sigma,
// with R and S in closed form. n = (f1 x f2) / d, d = |f1 x f2|, s = tr S = sqrt(tr F^T F + 2 d):
//   R = [f1 + f2 x n, f2 + n x f1] / s,   S = (F^T F + d I) / s.
// Its exact gradient needs the skew part a, since sigma and S do not commute for an anisotropic law:
//   a = (S12 (sigma1 - sigma2) + sigma3 (S22 - S11)) / s,  T = [[sigma1, sigma3 - a], [sigma3 + a, sigma2]],
//   dW/dx_i = A R T g_i.
// A triangle collapsed to a line or a point has no normal. A unit vector perpendicular to the line, or a fixed axis for
// a point, takes its place. The choice depends on the shape alone and is always finite.
//
// With Green's strain (Saint Venant-Kirchhoff):
//   F = [f1, f2],  e = (F^T F - I) / 2,  sigma = C e (second Piola-Kirchhoff),  W = A/2 e.sigma,
//   dW/dx_i = A F sigma g_i.
//
// All functions here process the slots in order and add to vertices in that order: one order of sums on every
// processor.

// Adds the forces at x (3 x V, m) and v (3 x V, m/s) to f (3 x V, N). Kelvin-Voigt damping with beta (s, see
// damping_of) makes sigma = C (e + beta de/dt), with the strain of the law. It does no work on rigid motions and never
// adds energy. v is not read if beta is 0 for all materials.
void add_membrane_forces(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                         std::span<const double> beta, const linear::VertexField& x, const linear::VertexField& v,
                         linear::VertexField& f);

// Returns the membrane energy, J.
double membrane_energy(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                       const linear::VertexField& x);

// Extent of the strain of a membrane, in principal strains of U - I.
struct StrainExtent {
  double largest = 0.0;       // -, largest |principal strain| of any triangle with material
  double beyond_limit = 0.0;  // -, 0..1, share of the rest area in triangles that are strained beyond their
                              // Material::strain_limit
};
StrainExtent measure_strain(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                            const linear::VertexField& x);

// Upper bound of the stiffening of a membrane with Green's strain at x over its rest state. It also bounds the largest
// eigenvalue of M^-1 K in units of StiffnessBound's bound at rest, if the sheet's triangles turn together. Let lambda
// be the larger principal stretch of a triangle, sigma (N/m) the larger principal stress, and c =
// MaterialLaw::least_membrane. The members are the largest values of all triangles:
//   stiffening = lambda^2 + tension, >= 1. The material stiffness at x is that at rest of displacements U R^T dx, no
//     longer than lambda dx.
//   tension = max(0, sigma) / c. The geometric stiffness is at most sigma A sum |grad dx|^2. That at rest, for
//     displacements along gradients, is at least c A sum |grad dx|^2.
// A sheet stretched in one direction reaches the bound: its stiffening is (3 lambda^2 - 1) / 2.
struct GreenStretch {
  double stiffening = 1.0;
  double tension = 0.0;
};
GreenStretch green_stretch(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                           const linear::VertexField& x);

}  // namespace kerf::fem
