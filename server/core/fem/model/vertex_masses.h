#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "server/core/fem/model/mass_redistribution.h"
#include "server/core/mesh/ids.h"

namespace kerf {
class StateHash;
}

namespace kerf::fem {

struct RestSheet;

// Vertices whose mass an edit recomputed or changed, including added ones, with their masses before the edit.
struct MassChange {
  std::vector<mesh::VertexId> vertices;  // unique
  std::vector<double> mass_before;       // kg, same length; 0 for an added vertex
  std::vector<double> dropped;           // kg, masses of the last vertices, which were removed
  std::size_t num_examined = 0;          // vertices whose mass was recomputed, changed or not
};

// The masses of vertices: a third of each triangle's mass to each corner. Vertices far too light for their stiffness,
// as along a cut, get mass from their neighbours (see mass_redistribution.h). Mass damping at a vertex is the mean over
// its triangles, weighted with their masses.
class VertexMasses {
 public:
  // Makes room for the edge lengths of `num_vertices` vertices.
  void reserve(std::size_t num_vertices) { edge_length_.reserve(num_vertices); }

  // Recomputes the masses near RestElements::touched(). Must be called once after each RestElements::follow().
  MassChange follow(const RestSheet& sheet);

  // kg, length V; 0 for a vertex without material, which never moves.
  [[nodiscard]] std::span<const double> mass() const { return mass_; }
  // 1/kg, length V; 0 where the mass is 0.
  [[nodiscard]] std::span<const double> inverse() const { return inverse_mass_; }
  [[nodiscard]] double total() const;  // kg
  // 1/s, Rayleigh alpha at a vertex: the damping force on it is -alpha m v.
  [[nodiscard]] double damping(mesh::VertexId vertex) const {
    return damping_.empty() ? common_damping_ : damping_[static_cast<std::size_t>(vertex)];
  }
  // m; smallest edge length of the sheet as built (see EdgeLengths) that at least a tenth of the vertices have.
  [[nodiscard]] double typical_edge_length() const;
  // m; longer side of the bounding box of the sheet as built, in material coordinates.
  [[nodiscard]] double built_extent() const { return built_extent_; }
  // Vertices whose mass the last follow() recomputed; unique.
  [[nodiscard]] std::span<const mesh::VertexId> changed() const { return changed_; }

  void add_to(StateHash& hash) const;

 private:
  void resize(const RestSheet& sheet);
  void set_edge_length(mesh::VertexId vertex, double length);
  // Sets the entries of lumped_mass_, mass_floor_, damping_, mass_tile_ and edge_length_ for a vertex.
  void set_lumped(const RestSheet& sheet, mesh::VertexId vertex);
  // Sets mass_ to the redistributed lumped masses.
  MassChange redistribute(const RestSheet& sheet);

  std::vector<double> lumped_mass_;  // kg, length V; a third of each triangle's mass
  std::vector<double> mass_floor_;   // kg, length V; a lighter vertex gets mass from its neighbours
  std::vector<double> damping_;      // 1/s, length V; empty if all materials have the same
  double common_damping_ = 0.0;      // 1/s, of all materials if damping_ is empty
  std::vector<MassTile> mass_tile_;  // length V
  std::vector<double> edge_length_;  // m, length V; edge length of the sheet as built at each vertex, 0 without
                                     // material
  std::map<double, std::int64_t> num_vertices_by_edge_length_;  // few entries: lengths are powers of two apart
  double built_extent_ = 0.0;                                   // m
  std::vector<double> mass_;
  std::vector<double> inverse_mass_;
  MassRedistribution redistribution_;
  std::vector<mesh::VertexId> changed_;
};

}  // namespace kerf::fem
