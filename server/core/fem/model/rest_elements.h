#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/fem/model/running_maximum.h"
#include "server/core/linear/index_set.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/ids.h"

namespace kerf {
class StateHash;
}
namespace kerf::mesh {
class TriangleMesh;
}

namespace kerf::fem {

// The triangles of a sheet at rest: constants of every slot, the slots around each vertex, and the laws of the
// materials. Triangle t has the material whose number is region(t) of the mesh, or the only material.
class RestElements {
 public:
  // Takes 1..kMaxMaterials valid materials: one for each region of the mesh, or a single one for all.
  RestElements(std::span<const Material> materials, MembraneLaw law) : materials_(materials, law) {}

  // Makes room for `num_slots` slots.
  void reserve(std::size_t num_slots);
  // Makes room in incident_slots() for what the next edits add.
  void make_room() { incident_.make_room(); }

  // Follows any number of edits that the mesh has already made. `rewritten` is sorted and unique, and holds all slots
  // that the edits rewrote and the mesh still has. Slots that the mesh no longer has are dropped.
  void follow(const mesh::TriangleMesh& mesh, std::span<const mesh::TriangleId> rewritten);

  [[nodiscard]] int num_slots() const { return num_slots_; }
  [[nodiscard]] int num_vertices() const { return incident_.num_rows(); }
  [[nodiscard]] const MaterialTable& materials() const { return materials_; }
  // Returns the law of a slot; that of material 0 for a slot without material.
  [[nodiscard]] const MaterialLaw& law(mesh::TriangleId slot) const {
    return materials_.of(blocks_[block_of(slot)], lane_of(slot));
  }
  [[nodiscard]] bool has_material(mesh::TriangleId slot) const {
    return blocks_[block_of(slot)].area[lane_of(slot)] > 0.0;
  }
  // Returns the vertices of a slot with material.
  [[nodiscard]] std::array<mesh::VertexId, 3> corners(mesh::TriangleId slot) const {
    const ElementBlock& block = blocks_[block_of(slot)];
    const std::size_t l = lane_of(slot);
    return {block.vertex[0][l], block.vertex[1][l], block.vertex[2][l]};
  }
  // Returns ceil(num_slots / kLanes) blocks; lanes beyond num_slots have no material.
  [[nodiscard]] std::span<const ElementBlock> blocks() const { return blocks_; }
  // Solid slots around each vertex, ascending.
  [[nodiscard]] const linear::RowStore<mesh::TriangleId>& incident_slots() const { return incident_; }
  // 1/m, reciprocal of the least height of the slot's triangle at rest; 0 without material.
  [[nodiscard]] double gradient(mesh::TriangleId slot) const {
    return gradients_.value(static_cast<std::size_t>(slot));
  }
  // 1/m, reciprocal of the least height of any triangle at rest; 0 without material.
  [[nodiscard]] double largest_gradient() const { return gradients_.value(); }
  [[nodiscard]] double area() const;  // m^2, of the sheet at rest

  // Slots that the last follow() wrote or dropped; may repeat.
  [[nodiscard]] std::span<const mesh::TriangleId> changed_slots() const { return changed_slots_; }
  // Vertices that the slots written or dropped by the last follow() had before it, or have after it. Vertices that the
  // mesh no longer has are left out.
  [[nodiscard]] const linear::IndexSet& touched() const { return touched_; }

  void add_to(StateHash& hash) const;

 private:
  static std::size_t block_of(mesh::TriangleId slot) { return static_cast<std::size_t>(slot / kLanes); }
  static std::size_t lane_of(mesh::TriangleId slot) { return static_cast<std::size_t>(slot % kLanes); }
  // Empties the slots that the mesh no longer has. Returns the remaining vertices of their triangles, in any order,
  // repeated.
  std::vector<mesh::VertexId> drop_slots(const mesh::TriangleMesh& mesh);
  // Sets a slot to the triangle that the mesh has there.
  void set_element(const mesh::TriangleMesh& mesh, mesh::TriangleId slot);
  void write_element(mesh::TriangleId slot, const std::array<mesh::VertexId, 3>& vertices,
                     const Eigen::Matrix2d& Dm_inv, double area, std::uint8_t material);
  // Updates the slots around the touched vertices.
  void set_incidence(std::span<const mesh::TriangleId> rewritten);

  MaterialTable materials_;
  int num_slots_ = 0;
  std::vector<ElementBlock> blocks_;
  RunningMaximum gradients_;  // 1/m, reciprocal of the least height, by slot
  linear::RowStore<mesh::TriangleId> incident_;
  std::vector<mesh::TriangleId> changed_slots_;
  linear::IndexSet touched_;
  linear::IdSet rewritten_;  // scratch of set_incidence()
};

// A mesh and the elements that follow it.
struct RestSheet {
  const mesh::TriangleMesh& mesh;
  const RestElements& elements;
};

// Returns the number of the material of a slot of the mesh.
std::uint8_t material_at(const RestSheet& sheet, mesh::TriangleId slot);

}  // namespace kerf::fem
