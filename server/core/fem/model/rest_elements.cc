#include "server/core/fem/model/rest_elements.h"

#include <algorithm>
#include <iterator>

#include <Eigen/LU>

#include "server/base/check.h"
#include "server/base/state_hash.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {

using mesh::TriangleId;
using mesh::VertexId;

void RestElements::reserve(std::size_t num_slots) {
  blocks_.reserve(num_slots / kLanes + 1);
}

void RestElements::follow(const mesh::TriangleMesh& mesh, std::span<const TriangleId> rewritten) {
  const int num_slots_before = num_slots_;
  const std::vector<VertexId> orphaned = drop_slots(mesh);
  num_slots_ = mesh.num_triangle_slots();
  const auto num_slots = static_cast<std::size_t>(num_slots_);
  blocks_.resize((num_slots + kLanes - 1) / kLanes);
  gradients_.resize(num_slots);
  incident_.resize(mesh.num_vertices());
  touched_.resize(static_cast<std::size_t>(mesh.num_vertices()));
  rewritten_.resize(num_slots);

  touched_.clear();
  for (const VertexId v : orphaned) touched_.insert(v);
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
  gradients_.update(rewritten);
  changed_slots_.assign(rewritten.begin(), rewritten.end());
  for (int slot = num_slots_; slot < num_slots_before; ++slot) changed_slots_.push_back(slot);
}

double RestElements::area() const {
  double total = 0.0;
  for (const ElementBlock& block : blocks_) {
    for (const double area : block.area) total += area;
  }
  return total;
}

std::vector<VertexId> RestElements::drop_slots(const mesh::TriangleMesh& mesh) {
  std::vector<VertexId> orphaned;
  for (TriangleId slot = mesh.num_triangle_slots(); slot < num_slots_; ++slot) {
    if (!has_material(slot)) continue;
    for (const VertexId v : corners(slot)) orphaned.push_back(v);
    write_element(slot, {0, 0, 0}, Eigen::Matrix2d::Zero(), 0.0, 0);  // clears a lane of the last block that may remain
  }
  std::erase_if(orphaned, [&](VertexId v) { return v >= mesh.num_vertices(); });
  return orphaned;
}

void RestElements::set_incidence(std::span<const TriangleId> rewritten) {
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

void RestElements::set_element(const mesh::TriangleMesh& mesh, TriangleId slot) {
  if (!mesh.is_solid(slot)) return write_element(slot, {0, 0, 0}, Eigen::Matrix2d::Zero(), 0.0, 0);
  const std::uint8_t material = material_at({mesh, *this}, slot);
  const Eigen::Matrix2d Dm = materials_[material].axes * mesh.rest_edges(slot);
  const double area = 0.5 * Dm.determinant();
  KERF_CHECK(area > 0.0, "a solid triangle has positive rest area");
  write_element(slot, mesh.vertices(slot), Dm.inverse(), area, material);
}

void RestElements::write_element(TriangleId slot, const std::array<VertexId, 3>& vertices,
                                 const Eigen::Matrix2d& Dm_inv, double area, std::uint8_t material) {
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

void RestElements::add_to(StateHash& hash) const {
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
  hash.add(largest_gradient());
  for (int i = 0; i < incident_.num_rows(); ++i) hash.add_span(incident_.row(i));
}

std::uint8_t material_at(const RestSheet& sheet, TriangleId slot) {
  const MaterialTable& materials = sheet.elements.materials();
  if (materials.has_one()) return 0;
  const std::int32_t region = sheet.mesh.region(slot);
  KERF_CHECK(region >= 0 && static_cast<std::size_t>(region) < materials.size(), "each region has a material");
  return static_cast<std::uint8_t>(region);
}

}  // namespace kerf::fem
