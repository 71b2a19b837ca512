#include "server/core/fem/model/vertex_masses.h"

#include <algorithm>
#include <array>

#include "server/base/interruption.h"
#include "server/base/state_hash.h"
#include "server/core/fem/model/rest_elements.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {

using mesh::TriangleId;
using mesh::VertexId;

MassChange VertexMasses::follow(const RestSheet& sheet) {
  const auto num_before = static_cast<std::ptrdiff_t>(mass_.size());
  const std::vector<double> dropped(mass_.begin() + std::min<std::ptrdiff_t>(sheet.mesh.num_vertices(), num_before),
                                    mass_.end());
  resize(sheet);
  for (const VertexId v : sheet.elements.touched().members()) {
    interruption_point();
    set_lumped(sheet, v);
  }
  MassChange change = redistribute(sheet);
  change.dropped = dropped;
  changed_ = change.vertices;
  return change;
}

void VertexMasses::resize(const RestSheet& sheet) {
  const auto num_vertices = static_cast<std::size_t>(sheet.mesh.num_vertices());
  const MaterialTable& materials = sheet.elements.materials();
  lumped_mass_.resize(num_vertices, 0.0);
  mass_floor_.resize(num_vertices, 0.0);
  mass_tile_.resize(num_vertices);
  for (std::size_t v = num_vertices; v < edge_length_.size(); ++v) set_edge_length(static_cast<VertexId>(v), 0.0);
  edge_length_.resize(num_vertices, 0.0);
  built_extent_ = sheet.mesh.edge_lengths().bounds.sizes().maxCoeff();
  common_damping_ = materials[0].material.mass_damping;
  if (!materials.has_one_mass_damping()) damping_.resize(num_vertices, 0.0);
  mass_.resize(num_vertices, 0.0);
  inverse_mass_.resize(num_vertices, 0.0);
}

void VertexMasses::set_edge_length(VertexId vertex, double length) {
  double& of_vertex = edge_length_[static_cast<std::size_t>(vertex)];
  if (of_vertex == length) return;
  const auto before = num_vertices_by_edge_length_.find(of_vertex);
  if (before != num_vertices_by_edge_length_.end() && --before->second == 0) num_vertices_by_edge_length_.erase(before);
  if (length > 0.0) ++num_vertices_by_edge_length_[length];
  of_vertex = length;
}

void VertexMasses::set_lumped(const RestSheet& sheet, VertexId vertex) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
  const RestElements& elements = sheet.elements;
  const MaterialTable& materials = elements.materials();
  // Factors common to all triangles are left out of the sums.
  const bool is_mixed = !materials.has_one();
  double mass = 0.0;
  double floor = 0.0;
  double damping = 0.0;
  double area = 0.0, material_area = 0.0;  // m^2, in space and in the material plane
  for (const TriangleId slot : elements.incident_slots().row(vertex)) {
    const ElementBlock& block = elements.blocks()[static_cast<std::size_t>(slot / kLanes)];
    const std::size_t l = static_cast<std::size_t>(slot % kLanes);
    std::array<double, 2> g{};
    for (std::size_t c = 0; c < 2; ++c) {
      if (block.vertex[0][l] == vertex) g[c] = -block.g1[c][l] - block.g2[c][l];
      if (block.vertex[1][l] == vertex) g[c] = block.g1[c][l];
      if (block.vertex[2][l] == vertex) g[c] = block.g2[c][l];
    }
    const MaterialLaw& law = materials.of(block, l);
    const double part = corner_stiffness(g[0], g[1], block.area[l], law.membrane);
    const double part_mass = (is_mixed ? law.surface_density : 1.0) * block.area[l];
    mass += part_mass;
    floor += (is_mixed ? law.unit_floor : 1.0) * part;
    damping += part_mass * law.material.mass_damping;
    area += block.area[l];
    if (mesh.is_curved()) material_area += mesh.material_area(slot);
  }
  const auto v = static_cast<std::size_t>(vertex);
  lumped_mass_[v] = (is_mixed ? 1.0 : materials[0].surface_density) * mass / 3.0;
  if (!materials.has_one_mass_damping()) damping_[v] = mass > 0.0 ? damping / mass : 0.0;
  mass_tile_[v] = mass_tile(mesh.edge_lengths(), mesh.rest_position(vertex));
  const double edge_length = mesh.edge_lengths().at(mesh.rest_position(vertex));
  set_edge_length(vertex, mass > 0.0 ? edge_length : 0.0);
  const double area_ratio = material_area > 0.0 ? area / material_area : 1.0;
  mass_floor_[v] = (is_mixed ? 1.0 : materials[0].unit_floor) * edge_length * edge_length * floor * area_ratio;
}

MassChange VertexMasses::redistribute(const RestSheet& sheet) {
  MassChange change;
  const linear::IndexSet& touched = sheet.elements.touched();
  const std::span<const VertexId> updated = redistribution_.update(
      {sheet.elements.incident_slots(), sheet.elements.blocks(), lumped_mass_, mass_floor_, mass_tile_},
      touched.members(), mass_);
  change.num_examined = updated.size();
  const std::span<const double> before = redistribution_.mass_before();
  for (std::size_t i = 0; i < updated.size(); ++i) {
    const auto v = static_cast<std::size_t>(updated[i]);
    if (mass_[v] == before[i] && !touched.contains(updated[i])) continue;
    change.vertices.push_back(updated[i]);
    change.mass_before.push_back(before[i]);
    inverse_mass_[v] = mass_[v] > 0.0 ? 1.0 / mass_[v] : 0.0;
  }
  return change;
}

double VertexMasses::total() const {
  double total = 0.0;
  for (const double m : mass_) total += m;
  return total;
}

double VertexMasses::typical_edge_length() const {
  constexpr double kShare = 0.1;  // of the vertices
  std::int64_t total = 0;
  for (const auto& [length, count] : num_vertices_by_edge_length_) total += count;
  for (const auto& [length, count] : num_vertices_by_edge_length_) {
    if (static_cast<double>(count) >= kShare * static_cast<double>(total)) return length;
  }
  return 0.0;
}

void VertexMasses::add_to(StateHash& hash) const {
  for (const std::vector<double>* field : {&lumped_mass_, &mass_floor_, &damping_, &mass_, &inverse_mass_}) {
    hash.add_span(std::span<const double>(*field));
  }
}

}  // namespace kerf::fem
