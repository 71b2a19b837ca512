#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/linear/index_set.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/edge_lengths.h"
#include "server/core/mesh/ids.h"

// Keeps the small triangles along a cut from dictating the explicit time step of the whole sheet.
//
// The step of a vertex goes with sqrt(mass / stiffness). In two dimensions the stiffness at a vertex does not depend on
// the size of the triangles around it, its mass does: a triangle a tenth as high as the others costs ten times the
// substeps. Along a cut, vertices that are far too light for their stiffness are therefore given mass of their
// neighbours, which keeps total mass, linear momentum and free fall exact and moves mass by about an edge length, as
// lumping itself does. Static equilibria see only their weight moved as far. Accuracy is traded for speed at the scale
// of the mesh only; sheets as generated have no vertex that needs it.
namespace kerf::fem {

// A vertex at this part of its floor has enough.  -
inline constexpr double kMassReached = 0.9;

// The squares that a vertex lies in, of two grids over the material plane, the second shifted by half a square both
// ways: equal numbers, same square. Squares are kMassTileEdges edge lengths wide, as the sheet as built has them there.
using MassTile = std::array<std::uint64_t, 2>;
inline constexpr double kMassTileEdges = 8.0;
MassTile mass_tile(const mesh::EdgeLengths& lengths, const Eigen::Vector2d& at);

// Trace of the stiffness that a corner with shape function gradient (gx, gy), 1/m, has in a triangle of `area`, m^2,
// under the membrane law C, N/m: A tr(B^T C B) with B the corner's strain-displacement matrix.  N/m
double corner_stiffness(double gx, double gy, double area, const Eigen::Matrix3d& C);

// Lumped masses and what they are redistributed over.
struct MassProblem {
  const RowStore<mesh::TriangleId>& incident_slots;
  std::span<const ElementBlock> blocks;
  std::span<const double> lumped;   // kg, length V
  std::span<const double> floor;    // kg, length V; > 0 where there is material
  std::span<const MassTile> tiles;  // length V
};

// The redistributed masses, kept up to date through edits at a cost that depends on what an edit touches.
//
// One pass. Light vertices and all vertices of their tile within kReach edges of one form domains: the connected parts
// of that set, tile by tile. Inside each domain by itself mass moves along edges, towards vertices below their floor
// from those that are further above: diffusion of mass / floor, in rounds, until every vertex has (nearly) reached its
// floor or nothing is gained any more. So the masses of a domain are a function of the domain alone, and an edit
// concerns the domains that it touches or that its own grow into. Tiles bound what a domain can grow to where cuts lie
// close together all over the sheet.
class MassPass {
 public:
  static constexpr int kReach = 3;  // edges

  // grid: of MassTile that tiles are taken from. Vertices below light_below times their floor are light.
  MassPass(int grid, double light_below) : grid_(static_cast<std::size_t>(grid)), light_below_(light_below) {}

  // As of MassRedistribution, of this pass.
  std::span<const mesh::VertexId> update(const MassProblem& problem, std::span<const mesh::VertexId> touched,
                                         std::span<double> mass);
  [[nodiscard]] std::span<const double> mass_before() const { return mass_before_; }

 private:
  void dissolve(std::int32_t domain);
  bool gather_reach(const MassProblem& problem);
  void store_domain(std::vector<mesh::VertexId> members);
  [[nodiscard]] bool share_tile(const MassProblem& problem, mesh::VertexId a, mesh::VertexId b) const;

  std::size_t grid_;
  double light_below_;  // -

  std::vector<std::int32_t> domain_of_;               // length V; kNone: in none
  std::vector<std::vector<mesh::VertexId>> domains_;  // members, sorted; empty: free
  std::vector<std::int32_t> free_domains_;
  // Scratch of update().
  IdSet region_;     // touched vertices, dissolved domains, and in the end what was reached
  IdSet reach_;      // light vertices of the region and what is near them
  IdSet parted_;     // of those, what is in a domain already
  IndexSet domain_;  // one domain, in ascending order
  std::vector<double> mass_before_;
};

// The redistributed masses, kept up to date through edits at a cost that depends on what an edit touches: one pass, and
// another over tiles shifted by half of one, for the few vertices that the borders of tiles have cut off from mass.
class MassRedistribution {
 public:
  // `touched`: vertices whose lumped mass, floor, tile or neighbours changed since the last call, new ones included;
  // all of them still there; may repeat. `mass` (kg, length V) holds the result of the last call, 0 for new vertices,
  // and is brought up to date; V may be less than before, where the last vertices are gone. Returns the vertices that
  // were looked at, `touched` among them, unique, valid until the next call, as is mass_before(): what they had, kg.
  std::span<const mesh::VertexId> update(const MassProblem& problem, std::span<const mesh::VertexId> touched,
                                         std::span<double> mass);
  [[nodiscard]] std::span<const double> mass_before() const { return second_.mass_before(); }

 private:
  MassPass first_{0, 1.0};
  MassPass second_{1, kMassReached};
  std::vector<double> between_;                // kg, length V, after the first pass
  std::vector<mesh::VertexId> touched_again_;  // scratch
};

}  // namespace kerf::fem
