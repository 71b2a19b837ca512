#pragma once

#include <span>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Linear triangle with the plane-stress law C of its material (N/m, Voigt (e11, e22, 2 e12), material axes), by
// MaterialTable::membrane_law(). Co-rotational:
//   F = [x1 - x0, x2 - x0] Dm^-1 (3x2) = R S,  e = S - I,  sigma = C e,  W = A/2 e.sigma,
// with R and S in closed form. n = (f1 x f2) / d, d = |f1 x f2|, s = tr S = sqrt(tr F^T F + 2 d):
//   R = [f1 + f2 x n, f2 + n x f1] / s,   S = (F^T F + d I) / s.
// Its exact gradient needs the skew part a, since sigma and S do not commute for an anisotropic law:
//   a = (S12 (sigma1 - sigma2) + sigma3 (S22 - S11)) / s,  T = [[sigma1, sigma3 - a], [sigma3 + a, sigma2]],
//   dW/dx_i = A R T g_i.
// A triangle collapsed to a line or a point has no normal; one is chosen perpendicular to the line, or fixed axes: the
// same for the same shape, always finite.
//
// With Green's strain (Saint Venant-Kirchhoff):
//   F = [f1, f2],  e = (F^T F - I) / 2,  sigma = C e (second Piola-Kirchhoff),  W = A/2 e.sigma,  dW/dx_i = A F sigma
//   g_i.
//
// Everything here works on the slots in order and adds to vertices in that order: one sum order, whatever the
// processor.

// f (3 x V, N) += forces at x (3 x V, m) and v (3 x V, m/s). Kelvin-Voigt damping with beta (s, see damping_of): sigma
// = C (e + beta de/dt), with the strain of the law, which does no work on rigid motions and never adds energy. v is not
// read where beta is 0.
void add_membrane_forces(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                         std::span<const double> beta, const mesh::VertexField& x, const mesh::VertexField& v,
                         mesh::VertexField& f);

// J.
double membrane_energy(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                       const mesh::VertexField& x);

// How far a membrane is strained, in principal strains of U - I.
struct StrainExtent {
  double largest = 0.0;       // -, largest |principal strain| of any triangle with material
  double beyond_limit = 0.0;  // -, share of the rest area where it is above Material::strain_limit; 0..1
};
StrainExtent measure_strain(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                            const mesh::VertexField& x);

// How much stiffer than at rest, at most, the triangles of a membrane with Green's strain are at x, and so the largest
// eigenvalue of M^-1 K in units of StiffnessBound's bound at rest, of a sheet whose triangles turn together. With the
// larger principal stretch lambda and stress sigma, N/m, of a triangle and c = MaterialLaw::least_membrane, the largest
// of all triangles:
//   stiffening = lambda^2 + tension, >= 1. The material stiffness at x is that at rest of displacements U R^T dx, no
//   longer than lambda dx.
//   tension = max(0, sigma) / c. The geometric stiffness is at most sigma A sum |grad dx|^2, and that at rest, for
//   displacements along gradients, at least c A sum |grad dx|^2.
// Of a sheet stretched in one direction stiffening is (3 lambda^2 - 1) / 2, and reached.
struct GreenStretch {
  double stiffening = 1.0;
  double tension = 0.0;
};
GreenStretch green_stretch(std::span<const ElementBlock> blocks, const MaterialTable& materials,
                           const mesh::VertexField& x);

}  // namespace kerf::fem
