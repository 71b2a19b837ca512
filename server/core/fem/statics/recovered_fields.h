#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/model/model.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Strain and stress of the membrane, constant in each triangle, and what they are at vertices. All of them are plane
// and symmetric, and are seen from the sheet: rotations do not show.
enum class MembraneField {
  kBiotStrain,    // -, e = U - I with F = R U: (e11, e22, 2 e12)
  kBiotStress,    // Pa, (s11, s22, s12): per area at rest, the symmetric part of R^T P, conjugate to e; of the
                  // co-rotational law C e / thickness
  kCauchyStress,  // Pa, (s11, s22, s12): what the sheet as it is now transmits per area, of the thickness at rest, in
                  // axes turned along with it by R
};

enum class FieldAxes {
  kMaterial,  // 1 along the fibres of the triangle's material
  kRest,      // 1 along x of the rest plane
};

// At x (3 x V, m); one a slot, 0 without material.
[[nodiscard]] std::vector<Eigen::Vector3d> triangle_field(const Model& model, const mesh::VertexField& x,
                                                          MembraneField field, FieldAxes axes);

enum class Recovery {
  kMean,  // of the triangles at the vertex, weighted with areas at rest: bounded by their values, and of first order at
          // the border, where they are all on one side
  kPatch,  // superconvergent patch recovery (Zienkiewicz, Zhu 1992): the plane fitted through the values at the
           // centroids around the vertex, where strains of linear triangles are most nearly right, taken there; on the
           // border the mean of those of the neighbours inside, or, of a corner, of the next across its triangle, and
           // where there is none kMean. Of second order
};

// One a vertex, from one a slot; 0 for vertices without. What is on the other side of a cut has no part in it: a lip is
// border, of whose vertices each has triangles of one side, and patches are closed fans, which no cut crosses. Where
// materials meet, where fields jump, no patch crosses the border between them either, and a vertex has the mean of what
// lies on both sides of it. Fields in kMaterial axes only of materials of one direction.
[[nodiscard]] std::vector<Eigen::Vector3d> vertex_field(const Model& model, std::span<const Eigen::Vector3d> of_slots,
                                                        Recovery recovery);

}  // namespace kerf::fem
