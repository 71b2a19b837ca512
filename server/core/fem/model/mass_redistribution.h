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
// The stable step of a vertex is proportional to sqrt(mass / stiffness). In two dimensions the stiffness at a vertex
// does not depend on the size of the triangles around it, but its mass does. A triangle a tenth as high as the others
// costs ten times the substeps. Vertices along a cut that are far too light for their stiffness therefore get mass from
// their neighbours. Total mass, linear momentum and free fall stay exact. Mass moves by about an edge length, as
// lumping itself moves it. In static equilibria only the weight moves, by the same distance. Accuracy is traded for
// speed at the scale of the mesh only. Sheets as generated have no vertex that needs it.
namespace kerf::fem {

// -, share of its floor (MassProblem::floor) from which on a vertex has enough mass.
inline constexpr double kMassReached = 0.9;

// The square that contains a vertex, in each of two grids over the material plane. The second grid is shifted by half a
// square both ways. Equal numbers mean the same square. Squares are as wide as kMassTileEdges edge lengths of the sheet
// as built.
using MassTile = std::array<std::uint64_t, 2>;
inline constexpr double kMassTileEdges = 8.0;
MassTile mass_tile(const mesh::EdgeLengths& lengths, const Eigen::Vector2d& at);

// Returns the trace of the stiffness of a triangle at a corner, A tr(B^T C B), N/m. (gx, gy), 1/m, is the corner's
// shape function gradient, B its strain-displacement matrix. `area` A is in m^2, C the membrane law in N/m.
double corner_stiffness(double gx, double gy, double area, const Eigen::Matrix3d& C);

// Lumped masses and the data needed to redistribute them.
struct MassProblem {
  const linear::RowStore<mesh::TriangleId>& incident_slots;
  std::span<const ElementBlock> blocks;
  std::span<const double> lumped;   // kg, length V
  std::span<const double> floor;    // kg, length V, least mass wanted for the stiffness of each vertex; > 0 where there
                                    // is material
  std::span<const MassTile> tiles;  // length V
};

// One pass of the redistribution, kept up to date through edits at a cost that depends on the size of the edit.
//
// Domains are made of light vertices, and of all vertices of the same tile within kReach edges of one. Each connected
// part of these vertices in a tile is a domain. Mass moves along edges inside each domain, to vertices below their
// floor from neighbours with more mass / floor. It is a diffusion of mass / floor, in rounds, until every vertex has
// (nearly) reached its floor or nothing improves. The masses of a domain are therefore a function of the domain alone.
// An edit affects the domains that it touches, and those that its new domains grow into. Tiles bound the growth of
// domains where cuts lie close together all over the sheet.
class MassPass {
 public:
  static constexpr int kReach = 3;  // edges

  // `grid`: index into MassTile, 0 or 1. A vertex is light if its lumped mass is below light_below (-) times its floor,
  // the least mass wanted.
  MassPass(int grid, double light_below) : grid_(static_cast<std::size_t>(grid)), light_below_(light_below) {}

  // Updates the masses of this pass; see MassRedistribution::update.
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

  std::vector<std::int32_t> domain_of_;               // length V; kNone if in no domain
  std::vector<std::vector<mesh::VertexId>> domains_;  // members of each domain, sorted; empty if the number is free
  std::vector<std::int32_t> free_domains_;
  // Scratch of update().
  linear::IdSet region_;     // touched vertices, dissolved domains, and finally all reached vertices
  linear::IdSet reach_;      // light vertices of the region and vertices near them
  linear::IdSet parted_;     // vertices of reach_ already assigned to a domain
  linear::IndexSet domain_;  // one domain, in ascending order
  std::vector<double> mass_before_;
};

// The redistributed masses, kept up to date through edits at a cost that depends on the size of the edit. A second pass
// over tiles shifted by half a tile serves the few vertices that tile borders cut off from mass.
class MassRedistribution {
 public:
  // Brings `mass` up to date. `touched` lists vertices whose lumped mass, floor, tile or neighbours changed since the
  // last call, including new ones. They must exist and may repeat. `mass` (kg, length V) holds the result of the last
  // call, 0 for new vertices. V may have decreased, if the last vertices were removed. Returns the examined vertices,
  // including `touched`, unique. This list, and mass_before() with the former masses of its vertices (kg), are valid
  // until the next call.
  std::span<const mesh::VertexId> update(const MassProblem& problem, std::span<const mesh::VertexId> touched,
                                         std::span<double> mass);
  [[nodiscard]] std::span<const double> mass_before() const { return second_.mass_before(); }

 private:
  MassPass first_{0, 1.0};
  MassPass second_{1, kMassReached};
  std::vector<double> between_;                // kg, length V, result of the first pass
  std::vector<mesh::VertexId> touched_again_;  // scratch
};

}  // namespace kerf::fem
