#pragma once

#include <span>

#include <Eigen/Core>

#include "server/fem/element_block.h"
#include "server/fem/row_store.h"
#include "server/mesh/ids.h"

// Keeps the small triangles along a cut from dictating the explicit time step of the whole sheet.
//
// The step of a vertex goes with sqrt(mass / stiffness). In two dimensions the stiffness at a vertex does not depend on
// the size of the triangles around it, its mass does: a triangle a tenth as high as the others costs ten times the
// substeps. Along a cut, vertices that are far too light for their stiffness are therefore given mass of their
// neighbours, which keeps total mass, linear momentum and free fall exact and moves mass by about an edge length, as
// lumping itself does. Static equilibria see only their weight moved as far. Accuracy is traded for speed at the scale
// of the mesh only; sheets as generated have no vertex that needs it.
namespace kerf::fem {

// Every vertex is brought towards this part of the mass / stiffness of an inner vertex of a uniform grid.  -
inline constexpr double kMassFloor = 0.25;

// Trace of the stiffness that a corner with shape function gradient (gx, gy), 1/m, has in a triangle of `area`, m^2,
// under the membrane law C, N/m: A tr(B^T C B) with B the corner's strain-displacement matrix.  N/m
double corner_stiffness(double gx, double gy, double area, const Eigen::Matrix3d& C);

// Moves mass along edges, towards vertices with mass[i] < floor[i], kg, from those that are further above their floor:
// diffusion of mass / floor, in rounds, until every vertex has (nearly) reached its floor or nothing is gained any
// more. Deterministic, and a function of the arguments alone.
void redistribute_mass(const RowStore<mesh::TriangleId>& incident_slots, std::span<const ElementBlock> blocks,
                       std::span<const double> floor, std::span<double> mass);

}  // namespace kerf::fem
