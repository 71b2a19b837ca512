#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/core/cut/curve.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::oracle {

// Expected result of cutting a sheet along strokes without rounding or snapping.
struct Outcome {
  std::int64_t pieces = 0;
  std::int64_t characteristic = 0;  // Euler's, of the opened sheet
  // Places where 1 (tips), 3, 4, 5 or more stretches of border and lip meet.
  std::array<std::int64_t, 4> places{};
  friend bool operator==(const Outcome&, const Outcome&) = default;
};

// The arrangement of border, lips and strokes (each point of which is first rounded to the lattice) in exact rational
// arithmetic. Needs neither triangles nor an order of insertion: with V, E and C the nodes, edges and connected parts
// of the planar graph of border, lips and all of the strokes that lies in the sheet S,
//   pieces = E - V + C + 1 - parts of the void,      chi(opened) = chi(S) - (V - E),
// the first by Euler's formula, the second because the opened sheet is a surface whose inside is S without the graph.
// `clearance`: lattice units; becomes how near two things that do not touch come to each other, about, where that is
// less than it was: a node and a stretch that does not end there, or two nodes of one segment.
Outcome exact_outcome(const mesh::TriangleMesh& sheet, const std::vector<cut::Stroke>& strokes, double& clearance);

}  // namespace kerf::oracle
