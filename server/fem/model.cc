#include "server/fem/model.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "server/base/check.h"
#include "server/base/state_hash.h"
#include "server/fem/mass_redistribution.h"
#include "server/mesh/triangle_mesh.h"

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

Eigen::Matrix2d rotation_into_material_axes(double direction) {
  const double c = std::cos(direction);
  const double s = std::sin(direction);
  return Eigen::Matrix2d{
      {c, s},
      {-s, c},
  };
}

template <typename T>
void sort_unique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

// The slots whose bending patch an edit of `rewritten` changes: themselves and their neighbours, of which one vertex of
// the patch is a corner.
std::vector<TriangleId> touched_patches(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten) {
  std::vector<TriangleId> touched;
  touched.reserve(4 * rewritten.size());
  for (const TriangleId slot : rewritten) {
    touched.push_back(slot);
    for (int k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(slot, k);
      if (other != mesh::kNone) touched.push_back(other);
    }
  }
  sort_unique(touched);
  return touched;
}

// The corner of `slot` that is not on its edge to `from`.
VertexId vertex_across(const mesh::TriangleMesh& mesh, TriangleId slot, TriangleId from) {
  for (int k = 0; k < 3; ++k) {
    if (mesh.neighbour(slot, k) == from) return mesh.vertices(slot)[static_cast<std::size_t>(k)];
  }
  KERF_CHECK(false, "neighbours are not mutual");
}

}  // namespace

Model::Model(const mesh::TriangleMesh& mesh, const Material& material)
    : material_(material),
      membrane_law_(fem::membrane_law(material)),
      bending_law_(fem::bending_law(material)),
      material_from_rest_(rotation_into_material_axes(material.direction)) {
  mesh::MeshEdit everything;
  everything.rewritten_triangles.resize(static_cast<std::size_t>(mesh.num_triangle_slots()));
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    everything.rewritten_triangles[static_cast<std::size_t>(t)] = t;
  }
  apply(mesh, everything);
}

MassChange Model::apply(const mesh::TriangleMesh& mesh, const mesh::MeshEdit& edit) {
  const std::vector<VertexId> touched = set_elements(mesh, edit.rewritten_triangles);
  for (const VertexId v : touched) set_lumped_mass(v);
  MassChange change = set_masses(mesh, touched);
  if (has_bending()) set_bending(mesh, edit.rewritten_triangles);
  return change;
}

void Model::resize(const mesh::TriangleMesh& mesh) {
  const auto num_vertices = static_cast<std::size_t>(mesh.num_vertices());
  KERF_CHECK(num_vertices >= mass_.size() && mesh.num_triangle_slots() >= num_slots_, "an edit never removes ids");
  num_slots_ = mesh.num_triangle_slots();
  blocks_.resize((static_cast<std::size_t>(num_slots_) + kLanes - 1) / kLanes);
  lumped_mass_.resize(num_vertices, 0.0);
  stiffness_.resize(num_vertices, 0.0);
  mass_.resize(num_vertices, 0.0);
  inverse_mass_.resize(num_vertices, 0.0);
  incident_.resize(mesh.num_vertices());
  if (!has_bending()) return;
  patches_.resize(static_cast<std::size_t>(num_slots_));
  bending_rows_.resize(mesh.num_vertices());
}

bool Model::has_material(TriangleId slot) const {
  return blocks_[block_of(slot)].area[lane_of(slot)] > 0.0;
}

std::array<VertexId, 3> Model::corners(TriangleId slot) const {
  const ElementBlock& block = blocks_[block_of(slot)];
  const std::size_t l = lane_of(slot);
  return {block.vertex[0][l], block.vertex[1][l], block.vertex[2][l]};
}

std::vector<VertexId> Model::set_elements(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten) {
  resize(mesh);
  std::vector<std::pair<VertexId, TriangleId>> incidences;  // of the rewritten slots, after
  std::vector<VertexId> touched;
  for (const TriangleId slot : rewritten) {
    if (has_material(slot)) {
      for (const VertexId v : corners(slot)) touched.push_back(v);
    }
    set_element(mesh, slot);
    if (!has_material(slot)) continue;
    for (const VertexId v : corners(slot)) {
      touched.push_back(v);
      incidences.emplace_back(v, slot);
    }
  }
  sort_unique(touched);
  std::sort(incidences.begin(), incidences.end());
  std::vector<TriangleId> row;
  auto next = incidences.begin();
  for (const VertexId v : touched) {
    row.clear();
    for (const TriangleId slot : incident_.row(v)) {
      if (!std::binary_search(rewritten.begin(), rewritten.end(), slot)) row.push_back(slot);
    }
    for (; next != incidences.end() && next->first == v; ++next) row.push_back(next->second);
    std::sort(row.begin(), row.end());
    incident_.set_row(v, row);
  }
  return touched;
}

void Model::set_element(const mesh::TriangleMesh& mesh, TriangleId slot) {
  ElementBlock& block = blocks_[block_of(slot)];
  const std::size_t l = lane_of(slot);
  std::array<VertexId, 3> vertices{0, 0, 0};
  Eigen::Matrix2d Dm_inv = Eigen::Matrix2d::Zero();
  double area = 0.0;
  if (mesh.is_solid(slot)) {
    vertices = mesh.vertices(slot);
    // Lattice differences are exact, those of positions are not where the sheet lies far from the origin.
    const auto edge = [&](VertexId to) {
      const mesh::LatticePoint& a = mesh.at(mesh.point(vertices[0]));
      const mesh::LatticePoint& b = mesh.at(mesh.point(to));
      const Eigen::Vector2d units(static_cast<double>(b.x - a.x), static_cast<double>(b.y - a.y));
      return Eigen::Vector2d(material_from_rest_ * (mesh.lattice().spacing * units));
    };
    Eigen::Matrix2d Dm;
    Dm.col(0) = edge(vertices[1]);
    Dm.col(1) = edge(vertices[2]);
    area = 0.5 * Dm.determinant();
    KERF_CHECK(area > 0.0, "a solid triangle has positive rest area");
    Dm_inv = Dm.inverse();
  }
  for (std::size_t c = 0; c < 2; ++c) {
    block.g1[c][l] = Dm_inv(0, static_cast<Eigen::Index>(c));
    block.g2[c][l] = Dm_inv(1, static_cast<Eigen::Index>(c));
  }
  block.area[l] = area;
  for (std::size_t k = 0; k < 3; ++k) block.vertex[k][l] = vertices[k];
}

void Model::set_lumped_mass(VertexId vertex) {
  double area = 0.0;
  double stiffness = 0.0;
  for (const TriangleId slot : incident_.row(vertex)) {
    const ElementBlock& block = blocks_[block_of(slot)];
    const std::size_t l = lane_of(slot);
    std::array<double, 2> g{};
    for (std::size_t c = 0; c < 2; ++c) {
      if (block.vertex[0][l] == vertex) g[c] = -block.g1[c][l] - block.g2[c][l];
      if (block.vertex[1][l] == vertex) g[c] = block.g1[c][l];
      if (block.vertex[2][l] == vertex) g[c] = block.g2[c][l];
    }
    area += block.area[l];
    stiffness += corner_stiffness(g[0], g[1], block.area[l], membrane_law_);
  }
  const auto v = static_cast<std::size_t>(vertex);
  lumped_mass_[v] = material_.density * material_.thickness * area / 3.0;
  stiffness_[v] = stiffness;
}

MassChange Model::set_masses(const mesh::TriangleMesh& mesh, const std::vector<VertexId>& touched) {
  MassChange change;
  if (touched.empty()) return change;
  // Mass and stiffness of an inner vertex of a uniform grid: six triangles of half a square each.
  const double h = mesh.base_edge_length();
  const double typical_mass = material_.density * material_.thickness * h * h;
  const double typical_stiffness = 2.0 * (membrane_law_(0, 0) + membrane_law_(1, 1) + 2.0 * membrane_law_(2, 2));
  std::vector<double> floor(stiffness_.size());
  for (std::size_t i = 0; i < floor.size(); ++i) {
    floor[i] = kMassFloor * stiffness_[i] * typical_mass / typical_stiffness;
  }
  std::vector<double> mass = lumped_mass_;
  redistribute_mass(incident_, blocks_, floor, mass);
  for (std::size_t i = 0; i < mass.size(); ++i) {
    const auto v = static_cast<VertexId>(i);
    if (mass[i] == mass_[i] && !std::binary_search(touched.begin(), touched.end(), v)) continue;
    change.vertices.push_back(v);
    change.mass_before.push_back(mass_[i]);
    mass_[i] = mass[i];
    inverse_mass_[i] = mass[i] > 0.0 ? 1.0 / mass[i] : 0.0;
  }
  return change;
}

void Model::set_bending(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten) {
  std::vector<VertexId> rows;
  for (const TriangleId slot : touched_patches(mesh, rewritten)) {
    BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    rows.insert(rows.end(), patch.vertex.begin(), patch.vertex.end());
    patch = make_patch(mesh, slot);
    rows.insert(rows.end(), patch.vertex.begin(), patch.vertex.end());
  }
  sort_unique(rows);
  if (!rows.empty() && rows.front() == mesh::kNone) rows.erase(rows.begin());
  std::vector<BendingEntry> entries;
  std::vector<TriangleId> around;
  for (const VertexId v : rows) {
    around.clear();
    for (const TriangleId slot : incident_.row(v)) {
      around.push_back(slot);
      const std::array<VertexId, 3> vertices = corners(slot);
      for (int k = 0; k < 3; ++k) {
        if (vertices[static_cast<std::size_t>(k)] != v) continue;
        const TriangleId across = mesh.neighbour(slot, k);
        if (across != mesh::kNone) around.push_back(across);
      }
    }
    sort_unique(around);
    sum_bending_row(v, around, entries);
    bending_rows_.set_row(v, entries);
  }
}

BendingPatch Model::make_patch(const mesh::TriangleMesh& mesh, TriangleId slot) const {
  BendingPatch patch;
  if (!has_material(slot)) return patch;
  const std::array<VertexId, 3> vertices = corners(slot);
  std::array<Eigen::Vector2d, 3> X;
  std::array<Eigen::Vector2d, 3> opposite;
  std::array<bool, 3> has_opposite{};
  for (std::size_t k = 0; k < 3; ++k) {
    patch.vertex[k] = vertices[k];
    X[k] = material_from_rest_ * mesh.rest_position(vertices[k]);
    opposite[k].setZero();
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(k));
    if (across == mesh::kNone) continue;
    patch.vertex[3 + k] = vertex_across(mesh, across, slot);
    opposite[k] = material_from_rest_ * mesh.rest_position(patch.vertex[3 + k]);
    has_opposite[k] = true;
  }
  patch.stiffness = bending_stiffness(X, opposite, has_opposite, bending_law_);
  return patch;
}

void Model::sum_bending_row(VertexId vertex, const std::vector<TriangleId>& slots,
                            std::vector<BendingEntry>& entries) const {
  entries.clear();
  for (const TriangleId slot : slots) {
    const BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    for (std::size_t a = 0; a < 6; ++a) {
      if (patch.vertex[a] != vertex) continue;
      for (std::size_t b = 0; b < 6; ++b) {
        const VertexId column = patch.vertex[b];
        if (column == mesh::kNone) continue;
        auto at = std::lower_bound(entries.begin(), entries.end(), column,
                                   [](const BendingEntry& entry, VertexId c) { return entry.column < c; });
        if (at == entries.end() || at->column != column) at = entries.insert(at, {0.0, column});
        at->value += patch.at(static_cast<int>(a), static_cast<int>(b));
      }
    }
  }
}

std::uint64_t Model::hash() const {
  StateHash hash;
  hash.add(num_slots_);
  for (const Eigen::Matrix3d* law : {&membrane_law_, &bending_law_}) {
    hash.add_span(std::span<const double>(law->data(), static_cast<std::size_t>(law->size())));
  }
  for (const ElementBlock& block : blocks_) {
    for (std::size_t c = 0; c < 2; ++c) {
      hash.add_span(std::span<const double>(block.g1[c]));
      hash.add_span(std::span<const double>(block.g2[c]));
    }
    hash.add_span(std::span<const double>(block.area));
    for (std::size_t k = 0; k < 3; ++k) hash.add_span(std::span<const VertexId>(block.vertex[k]));
  }
  for (const BendingPatch& patch : patches_) {
    hash.add_span(std::span<const VertexId>(patch.vertex));
    hash.add_span(std::span<const double>(patch.stiffness));
  }
  for (const std::vector<double>* field : {&lumped_mass_, &stiffness_, &mass_, &inverse_mass_}) {
    hash.add_span(std::span<const double>(*field));
  }
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
