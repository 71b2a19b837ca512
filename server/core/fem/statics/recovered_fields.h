#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

class Model;

// Strain and stress of the membrane, constant in each triangle, and recovered at vertices. All are plane, symmetric and
// relative to the sheet: rotations do not show.
enum class MembraneField {
  kBiotStrain,    // -, e = U - I with F = R U: (e11, e22, 2 e12)
  kBiotStress,    // Pa, (s11, s22, s12): per area at rest, the symmetric part of R^T P, conjugate to e; for the
                  // co-rotational law C e / thickness
  kCauchyStress,  // Pa, (s11, s22, s12): per current area, with the thickness at rest, in axes that R turns along
};

enum class FieldAxes {
  kMaterial,  // axis 1 is Material::direction of the triangle's material
  kRest,      // axis 1 is x of the rest plane
};

// Returns the field at x (3 x V, m), one value a slot; 0 for slots without material.
[[nodiscard]] std::vector<Eigen::Vector3d> triangle_field(const Model& model, const linear::VertexField& x,
                                                          MembraneField field, FieldAxes axes);

enum class Recovery {
  kMean,   // mean of the triangles at the vertex, weighted with areas at rest. Bounded by their values. Of first order
           // at the border, where all triangles are on one side of the vertex
  kPatch,  // superconvergent patch recovery (Zienkiewicz, Zhu 1992): evaluates at the vertex the plane fitted through
           // the values at the centroids around it, where strains of linear triangles are most accurate. A border
           // vertex takes the mean of its inner neighbours' planes. A vertex without such neighbours takes the planes
           // of inner vertices across its triangles, or kMean if there are none. Of second order
};

// Returns the field at each vertex, from one value a slot; 0 for vertices without slots. The other side of a cut has no
// influence. A lip is border, and each of its vertices has triangles of one side only. Patches of kPatch are closed
// fans of triangles, which no cut crosses. Fields jump where materials meet, so no patch crosses the border between
// them. A vertex there has the mean of both sides. Fields in kMaterial axes require materials of one direction.
[[nodiscard]] std::vector<Eigen::Vector3d> vertex_field(const Model& model, std::span<const Eigen::Vector3d> of_slots,
                                                        Recovery recovery);

}  // namespace kerf::fem
