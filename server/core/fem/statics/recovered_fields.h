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
  kMaterial,  // 1 along the fibres of the triangle's material
  kRest,      // 1 along x of the rest plane
};

// Returns the field at x (3 x V, m), one a slot; 0 without material.
[[nodiscard]] std::vector<Eigen::Vector3d> triangle_field(const Model& model, const linear::VertexField& x,
                                                          MembraneField field, FieldAxes axes);

enum class Recovery {
  kMean,   // mean of the triangles at the vertex, weighted with areas at rest. Bounded by their values; of first order
           // at the border, where they are all on one side
  kPatch,  // superconvergent patch recovery (Zienkiewicz, Zhu 1992): evaluates at the vertex the plane fitted through
           // the values at the centroids around it, where strains of linear triangles are most accurate. A border
           // vertex takes the mean of its inner neighbours' planes. A corner takes that of the vertex across its
           // triangle, and kMean if there is none. Of second order
};

// Returns the field at each vertex, from one value a slot; 0 for vertices without slots. The other side of a cut has no
// influence: a lip is border, whose vertices have triangles of one side each. Patches are closed fans, which no cut
// crosses. Fields jump where materials meet, so no patch crosses the border between them. A vertex there has the mean
// of both sides. Fields in kMaterial axes require materials of one direction.
[[nodiscard]] std::vector<Eigen::Vector3d> vertex_field(const Model& model, std::span<const Eigen::Vector3d> of_slots,
                                                        Recovery recovery);

}  // namespace kerf::fem
