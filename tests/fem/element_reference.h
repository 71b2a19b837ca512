#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/model/model.h"

// Computes the energy of a sheet and its derivatives in long double, from the constants of a model. The definitions are
// those of membrane.h, bending.h, bending_edge.h and hinge.h. Also bounds the error of double precision.
//
// The noise of a triangle. Differences of positions and their products with the gradients g of its corners, whose size
// is G = |g1| + |g2|, leave in F an error of
//   delta = u (1 + |d1| |g1| + |d2| |g2|) + moved G,   u = 2^-53,
// where positions are themselves off by `moved`. On a sliver |d| |g| is its aspect ratio and this is far more than u,
// in a sheet of ordinary triangles a few u. Its stretch S changes by as much. Its rotation R, and with it the normal,
// changes by that over the smaller principal stretch s. In the law of Green's strain s is 1, as it has no rotation.
// With the law's norm |C|, the area A and the strain e:
//   energy  A |C| (|e| + delta) delta,   force  A G |C| (1 + |e| / s) delta,
//   stiffness  A G^2 |C| (1 + |e| / s) (u + delta / s).
// For Green's strain, where delta becomes |F| delta, 1 + |F|^2 replaces 1 + |e| / s.
//
// The noise of bending. With differences d of positions, each entry of Q has u of the sum of its terms, and the force
// on a vertex u sum |Q| |d| + moved sum |Q|.
//
// The noise of bending by angles. Let a triangle of doubled area n have an edge of length l and a corner at a distance
// of a from it. Its normal is off by (u l a + moved (l + a)) / n, at most 2. So is the angle, and its derivatives by
// that share of their terms. Near pi an angle is off by 2 pi.
namespace kerf::fem {

struct Reference {
  explicit Reference(Eigen::Index num_vertices);

  long double energy = 0.0L;  // J
  Eigen::Matrix3Xd forces;    // N, 3 x V, minus the gradient of the energy; of smooth vertices
  Eigen::MatrixXd stiffness;  // N/m, 3V x 3V, its second derivative; where both vertices are smooth
  // Errors of double precision, to be multiplied by a number of roundings.
  double energy_noise = 0.0;        // J
  Eigen::VectorXd force_noise;      // N, length V
  Eigen::VectorXd balance_noise;    // N, length V, of angles: of their forces for the moments as they are, which must
                                    // have no resultant and no torque, be the moments right or not
  Eigen::MatrixXd stiffness_noise;  // N/m, V x V
  // Largest force there can be on a vertex, N, length V, whatever frame a collapsed triangle is given.
  Eigen::VectorXd force_bound;
  // True where double precision resolves the derivatives of the energy. They are unresolved at a corner of a triangle
  // of the co-rotational law that is collapsed to a line or a point: S = sqrt(F^T F) has a kink there. The same holds
  // at a vertex of a hinge that counts as collapsed, whose angle is given other derivatives (see hinge.h).
  std::vector<bool> is_smooth;
};

// x (3 x V, m), known to within `moved` (m).
Reference membrane_reference(const Model& model, const linear::VertexField& x, double moved);
Reference bending_reference(const Model& model, const linear::VertexField& x, double moved);
// Returns the reference of a model that bends by angles, without clamps.
Reference angle_reference(const Model& model, const linear::VertexField& x, double moved);

// N/m, of the terms that the stiffness of one triangle is summed of: A G^2 |C| (1 + |e| / s), without s where it is not
// resolved or the law is that of Green's strain. They cancel each other on a sliver that is folded nearly to a line.
double stiffness_terms(const ElementBlock& block, std::size_t lane, const MaterialTable& materials,
                       const linear::VertexField& x);

}  // namespace kerf::fem
