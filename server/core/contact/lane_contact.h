#pragma once

#include <cstdint>

#include "server/core/contact/collider.h"
#include "server/core/contact/prepared_collider.h"
#include "server/core/mesh/vertex_lanes.h"

// One collider against the vertices of a block, in vector code chosen for the processor at run time. Results have the
// same bits on every processor.
namespace kerf::contact {

// Distances to keep from colliders, m; minus infinity leaves a vertex alone.
using ThicknessLanes = mesh::VertexLanes::Lanes;

// Sets `gaps` (m) to the distance of each vertex less its thickness, by the distance of PreparedCollider::query().
void find_gaps(const PreparedCollider& collider, const ThicknessLanes& thickness, const mesh::VertexLanes& vertices,
               mesh::VertexLanes::Lanes& gaps);

// Effect of one collider on the vertices of a block.
struct LanePush {
  std::uint32_t pushed = 0;  // bit l: vertex l was closer than its thickness
  double farthest = 0.0;     // m, upper bound of the distance that any vertex was moved
  double least_gap = 0.0;    // m, least gap of all vertices; pushed ones count as 0
  double deepest = 0.0;      // m, largest push of any of the vertices along the collider's normal
  double residual = 0.0;     // m, upper bound of the penetration left by friction, which moves along the tangent into a
                             // curved surface
};

// Pushes vertices out of the collider; see ContactSolver.
LanePush push_out(const PreparedCollider& collider, const ThicknessLanes& thickness, mesh::VertexLanes& vertices);

}  // namespace kerf::contact
