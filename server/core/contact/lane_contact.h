#pragma once

#include <cstdint>

#include "server/core/contact/collider.h"
#include "server/core/contact/prepared_collider.h"
#include "server/core/mesh/vertex_lanes.h"

// Contact of one collider with the vertices of a block, in vector code that is chosen for the processor at run time.
// Results have the same bits on every processor.
namespace kerf::contact {

// Least distance from colliders for each vertex of a block, m; minus infinity leaves a vertex alone.
using ThicknessLanes = mesh::VertexLanes::Lanes;

// Sets `gaps` (m) for each vertex to its distance from the collider, as of PreparedCollider::query(), minus its
// thickness.
void find_gaps(const PreparedCollider& collider, const ThicknessLanes& thickness, const mesh::VertexLanes& vertices,
               mesh::VertexLanes::Lanes& gaps);

// Effect of one collider on the vertices of a block.
struct LanePush {
  std::uint32_t pushed = 0;  // bit l is set if vertex l was closer to the collider than its thickness
  double farthest = 0.0;     // m, upper bound of the distance that any vertex was moved
  double least_gap = 0.0;    // m, least of distance minus thickness over all vertices; pushed ones count as 0
  double deepest = 0.0;      // m, largest push of a vertex along the collider's normal
  double residual = 0.0;     // m, upper bound of the penetration that friction leaves, as it moves vertices along the
                             // tangent of a curved surface
};

// Pushes vertices out of the collider, with friction; see ContactSolver. `vertices.before` must be set.
LanePush push_out(const PreparedCollider& collider, const ThicknessLanes& thickness, mesh::VertexLanes& vertices);

}  // namespace kerf::contact
