#include "server/core/fem/model/model.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/LU>

#include "server/base/check.h"
#include "server/base/interruption.h"
#include "server/base/state_hash.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

std::size_t block_of(TriangleId slot) {
  return static_cast<std::size_t>(slot / kLanes);
}
std::size_t lane_of(TriangleId slot) {
  return static_cast<std::size_t>(slot % kLanes);
}

}  // namespace

Model::Model(const mesh::TriangleMesh& mesh, const Material& material, MembraneLaw law)
    : Model(mesh, std::span<const Material>(&material, 1), law) {}

Model::Model(const mesh::TriangleMesh& mesh, std::span<const Material> materials, MembraneLaw law)
    : materials_(materials, law) {
  mesh::MeshEdit everything;
  everything.rewritten_triangles.resize(static_cast<std::size_t>(mesh.num_triangle_slots()));
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    everything.rewritten_triangles[static_cast<std::size_t>(t)] = t;
  }
  // Reserves a quarter more for large arrays, so that the first cuts need not move them.
  edge_length_.reserve(static_cast<std::size_t>(mesh.num_vertices()) * 5 / 4);
  const std::size_t slots = everything.rewritten_triangles.size() * 5 / 4;
  blocks_.reserve(slots / kLanes + 1);
  if (has_bending()) patches_.reserve(slots);
  apply(mesh, everything);
  incident_.make_room();
  bending_rows_.make_room();
  bound_rows_.make_room();
}

MassChange Model::apply(const mesh::TriangleMesh& mesh, const mesh::MeshEdit& edit) {
  return follow(mesh, edit.rewritten_triangles);
}

MassChange Model::follow(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten,
                         PhaseObserver* observer) {
  enter_phase(observer, "elements");
  const int num_slots_before = num_slots_;
  const std::vector<VertexId> bereft = drop_slots(mesh);
  const std::vector<double> dropped(mass_.begin() + std::min<std::ptrdiff_t>(mesh.num_vertices(), num_vertices()),
                                    mass_.end());
  resize(mesh);
  set_elements(mesh, rewritten, bereft);
  gradients_.update(rewritten);
  enter_phase(observer, "masses");
  for (const VertexId v : touched_.members()) {
    interruption_point();
    set_lumped_mass(mesh, v);
  }
  MassChange change = set_masses();
  change.dropped = dropped;
  changed_masses_ = change.vertices;
  enter_phase(observer, "bending");
  rows_.clear();
  if (has_bending()) set_bending(mesh, rewritten);
  enter_phase(observer, "stability bound");
  changed_slots_.assign(rewritten.begin(), rewritten.end());
  for (int slot = num_slots_; slot < num_slots_before; ++slot) changed_slots_.push_back(slot);
  stiffness_bound_.update(stiffness_problem(mesh), touched_.members(), change.vertices, rows_.members());
  return change;
}

StiffnessProblem Model::stiffness_problem(const mesh::TriangleMesh& mesh) const {
  const RowStore<BendingEntry>& bending_rows = bending_bound_rows();
  return {blocks_, incident_, bending_rows, materials_, inverse_mass_, mesh.is_curved()};
}

std::vector<VertexId> Model::drop_slots(const mesh::TriangleMesh& mesh) {
  std::vector<VertexId> bereft;
  for (TriangleId slot = mesh.num_triangle_slots(); slot < num_slots_; ++slot) {
    if (!has_material(slot)) continue;
    for (const VertexId v : corners(slot)) bereft.push_back(v);
    write_element(slot, {0, 0, 0}, Eigen::Matrix2d::Zero(), 0.0, 0);  // clears a lane of the last block that may remain
  }
  std::erase_if(bereft, [&](VertexId v) { return v >= mesh.num_vertices(); });
  return bereft;
}

void Model::resize(const mesh::TriangleMesh& mesh) {
  const auto num_vertices = static_cast<std::size_t>(mesh.num_vertices());
  num_slots_ = mesh.num_triangle_slots();
  blocks_.resize((static_cast<std::size_t>(num_slots_) + kLanes - 1) / kLanes);
  gradients_.resize(static_cast<std::size_t>(num_slots_));
  lumped_mass_.resize(num_vertices, 0.0);
  mass_floor_.resize(num_vertices, 0.0);
  mass_tile_.resize(num_vertices);
  for (std::size_t v = num_vertices; v < edge_length_.size(); ++v) set_edge_length(static_cast<VertexId>(v), 0.0);
  edge_length_.resize(num_vertices, 0.0);
  built_extent_ = mesh.edge_lengths().bounds.sizes().maxCoeff();
  if (!materials_.has_one_mass_damping()) mass_damping_.resize(num_vertices, 0.0);
  mass_.resize(num_vertices, 0.0);
  inverse_mass_.resize(num_vertices, 0.0);
  incident_.resize(mesh.num_vertices());
  touched_.resize(num_vertices);
  rewritten_.resize(static_cast<std::size_t>(num_slots_));
  if (!has_bending()) return;
  patched_.resize(static_cast<std::size_t>(num_slots_));
  rows_.resize(num_vertices);
  row_sum_.resize(num_vertices);
  patches_.resize(static_cast<std::size_t>(num_slots_));
  bending_rows_.resize(mesh.num_vertices());
  edged_.resize(static_cast<std::size_t>(num_slots_));
  fitted_.resize(static_cast<std::size_t>(num_slots_));
  bending_edges_.resize(num_slots_);
  if (!mesh.is_curved()) return;
  rest_bending_.resize(static_cast<std::size_t>(num_slots_));
  bound_rows_.resize(mesh.num_vertices());
}

bool Model::has_material(TriangleId slot) const {
  return blocks_[block_of(slot)].area[lane_of(slot)] > 0.0;
}

std::array<VertexId, 3> Model::corners(TriangleId slot) const {
  const ElementBlock& block = blocks_[block_of(slot)];
  const std::size_t l = lane_of(slot);
  return {block.vertex[0][l], block.vertex[1][l], block.vertex[2][l]};
}

void Model::set_elements(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten,
                         const std::vector<VertexId>& bereft) {
  touched_.clear();
  for (const VertexId v : bereft) touched_.insert(v);
  const auto touch_corners = [&](TriangleId slot) {
    if (!has_material(slot)) return;
    for (const VertexId v : corners(slot)) {
      if (v < mesh.num_vertices()) touched_.insert(v);
    }
  };
  for (const TriangleId slot : rewritten) {
    touch_corners(slot);
    set_element(mesh, slot);
    touch_corners(slot);
  }
  set_incidence(rewritten);
}

void Model::set_incidence(const std::vector<TriangleId>& rewritten) {
  rewritten_.clear();
  for (const TriangleId slot : rewritten) rewritten_.insert(slot);
  // Lists the rewritten slots around each touched vertex, ascending: counts them, then fills them in.
  std::vector<std::size_t> first(touched_.size() + 1, 0);
  const auto for_corners = [&](const auto& visit) {
    for (const TriangleId slot : rewritten) {
      if (!has_material(slot)) continue;
      for (const VertexId v : corners(slot)) visit(static_cast<std::size_t>(touched_.place(v)), slot);
    }
  };
  for_corners([&](std::size_t place, TriangleId /*slot*/) { ++first[place + 1]; });
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<TriangleId> around(first.back());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for_corners([&](std::size_t place, TriangleId slot) { around[next[place]++] = slot; });

  std::vector<TriangleId> kept;
  std::vector<TriangleId> row;
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    const VertexId v = touched_.members()[i];
    kept.clear();
    for (const TriangleId slot : incident_.row(v)) {
      if (slot < num_slots_ && !rewritten_.contains(slot)) kept.push_back(slot);
    }
    row.clear();
    std::merge(kept.begin(), kept.end(), around.begin() + static_cast<std::ptrdiff_t>(first[i]),
               around.begin() + static_cast<std::ptrdiff_t>(first[i + 1]), std::back_inserter(row));
    incident_.set_row(v, row);
  }
}

void Model::set_element(const mesh::TriangleMesh& mesh, TriangleId slot) {
  if (!mesh.is_solid(slot)) return write_element(slot, {0, 0, 0}, Eigen::Matrix2d::Zero(), 0.0, 0);
  const std::uint8_t material = material_at(mesh, slot);
  const Eigen::Matrix2d Dm = materials_[material].axes * mesh.rest_edges(slot);
  const double area = 0.5 * Dm.determinant();
  KERF_CHECK(area > 0.0, "a solid triangle has positive rest area");
  write_element(slot, mesh.vertices(slot), Dm.inverse(), area, material);
}

std::uint8_t Model::material_at(const mesh::TriangleMesh& mesh, TriangleId slot) const {
  if (materials_.has_one()) return 0;
  const std::int32_t region = mesh.region(slot);
  KERF_CHECK(region >= 0 && static_cast<std::size_t>(region) < materials_.size(), "each region has a material");
  return static_cast<std::uint8_t>(region);
}

void Model::write_element(TriangleId slot, const std::array<VertexId, 3>& vertices, const Eigen::Matrix2d& Dm_inv,
                          double area, std::uint8_t material) {
  ElementBlock& block = blocks_[block_of(slot)];
  const std::size_t l = lane_of(slot);
  for (std::size_t c = 0; c < 2; ++c) {
    block.g1[c][l] = Dm_inv(0, static_cast<Eigen::Index>(c));
    block.g2[c][l] = Dm_inv(1, static_cast<Eigen::Index>(c));
  }
  block.area[l] = area;
  block.material[l] = material;
  const Eigen::RowVector2d first = -Dm_inv.row(0) - Dm_inv.row(1);
  gradients_.set(static_cast<std::size_t>(slot), std::max({first.norm(), Dm_inv.row(0).norm(), Dm_inv.row(1).norm()}));
  for (std::size_t k = 0; k < 3; ++k) block.vertex[k][l] = vertices[k];
}

void Model::set_edge_length(VertexId vertex, double length) {
  double& of_vertex = edge_length_[static_cast<std::size_t>(vertex)];
  if (of_vertex == length) return;
  const auto before = num_vertices_by_edge_length_.find(of_vertex);
  if (before != num_vertices_by_edge_length_.end() && --before->second == 0) num_vertices_by_edge_length_.erase(before);
  if (length > 0.0) ++num_vertices_by_edge_length_[length];
  of_vertex = length;
}

void Model::set_lumped_mass(const mesh::TriangleMesh& mesh, VertexId vertex) {
  // Factors common to all triangles are left out of the sums.
  const bool is_mixed = !materials_.has_one();
  double mass = 0.0;
  double floor = 0.0;
  double damping = 0.0;
  double area = 0.0, material_area = 0.0;  // m^2, in space and in the material plane
  for (const TriangleId slot : incident_.row(vertex)) {
    const ElementBlock& block = blocks_[block_of(slot)];
    const std::size_t l = lane_of(slot);
    std::array<double, 2> g{};
    for (std::size_t c = 0; c < 2; ++c) {
      if (block.vertex[0][l] == vertex) g[c] = -block.g1[c][l] - block.g2[c][l];
      if (block.vertex[1][l] == vertex) g[c] = block.g1[c][l];
      if (block.vertex[2][l] == vertex) g[c] = block.g2[c][l];
    }
    const MaterialLaw& law = materials_.of(block, l);
    const double part = corner_stiffness(g[0], g[1], block.area[l], law.membrane);
    const double part_mass = (is_mixed ? law.surface_density : 1.0) * block.area[l];
    mass += part_mass;
    floor += (is_mixed ? law.unit_floor : 1.0) * part;
    damping += part_mass * law.material.mass_damping;
    area += block.area[l];
    if (mesh.is_curved()) material_area += mesh.material_area(slot);
  }
  const auto v = static_cast<std::size_t>(vertex);
  lumped_mass_[v] = (is_mixed ? 1.0 : materials_[0].surface_density) * mass / 3.0;
  if (!materials_.has_one_mass_damping()) mass_damping_[v] = mass > 0.0 ? damping / mass : 0.0;
  mass_tile_[v] = mass_tile(mesh.edge_lengths(), mesh.rest_position(vertex));
  const double edge_length = mesh.edge_lengths().at(mesh.rest_position(vertex));
  set_edge_length(vertex, mass > 0.0 ? edge_length : 0.0);
  const double area_ratio = material_area > 0.0 ? area / material_area : 1.0;
  mass_floor_[v] = (is_mixed ? 1.0 : materials_[0].unit_floor) * edge_length * edge_length * floor * area_ratio;
}

MassChange Model::set_masses() {
  MassChange change;
  const std::span<const VertexId> updated =
      redistribution_.update({incident_, blocks_, lumped_mass_, mass_floor_, mass_tile_}, touched_.members(), mass_);
  change.num_examined = updated.size();
  const std::span<const double> before = redistribution_.mass_before();
  for (std::size_t i = 0; i < updated.size(); ++i) {
    const auto v = static_cast<std::size_t>(updated[i]);
    if (mass_[v] == before[i] && !touched_.contains(updated[i])) continue;
    change.vertices.push_back(updated[i]);
    change.mass_before.push_back(before[i]);
    inverse_mass_[v] = mass_[v] > 0.0 ? 1.0 / mass_[v] : 0.0;
  }
  return change;
}

std::uint64_t Model::hash() const {
  StateHash hash;
  hash.add(num_slots_);
  hash.add(static_cast<int>(materials_.membrane_law()));
  for (const MaterialLaw& law : materials_) {
    for (const Eigen::Matrix3d* matrix : {&law.membrane, &law.bending}) {
      hash.add_span(std::span<const double>(matrix->data(), static_cast<std::size_t>(matrix->size())));
    }
  }
  for (const ElementBlock& block : blocks_) {
    for (std::size_t c = 0; c < 2; ++c) {
      hash.add_span(std::span<const double>(block.g1[c]));
      hash.add_span(std::span<const double>(block.g2[c]));
    }
    hash.add_span(std::span<const double>(block.area));
    hash.add_span(std::span<const std::uint8_t>(block.material));
    for (std::size_t k = 0; k < 3; ++k) hash.add_span(std::span<const VertexId>(block.vertex[k]));
  }
  for (const BendingPatch& patch : patches_) {
    hash.add_span(std::span<const VertexId>(patch.vertex));
    hash.add_span(std::span<const double>(patch.stiffness));
  }
  for (int slot = 0; slot < bending_edges_.num_rows(); ++slot) {
    for (const BendingEdge& edge : bending_edges_.row(slot)) {
      hash.add_span(std::span<const VertexId>(edge.vertex));
      hash.add_span(std::span<const double>(edge.kink));
      hash.add_span(std::span<const double>(edge.load));
    }
  }
  for (const RestBending& rest : rest_bending_) {
    for (const Eigen::Vector3d& load : rest.load) hash.add_span(std::span<const double>(load.data(), 3));
    hash.add_span(std::span<const double>(rest.inertia.data(), 9));
    hash.add(rest.energy);
    hash.add_span(std::span<const double>(rest.excess));
  }
  for (const std::vector<double>* field : {&lumped_mass_, &mass_floor_, &mass_damping_, &mass_, &inverse_mass_}) {
    hash.add_span(std::span<const double>(*field));
  }
  hash.add(stiffness_bound());
  hash.add(largest_gradient());
  for (int i = 0; i < incident_.num_rows(); ++i) hash.add_span(incident_.row(i));
  for (int i = 0; i < bending_rows_.num_rows(); ++i) {
    const std::span<const BendingEntry> row = bending_rows_.row(i);
    hash.add(static_cast<std::uint64_t>(row.size()));
    for (const BendingEntry& entry : row) {
      hash.add(entry.value);
      hash.add(entry.column);
    }
  }
  return hash.value();
}

}  // namespace kerf::fem
