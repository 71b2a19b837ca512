// The bending part of Model.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "server/base/check.h"
#include "server/fem/model.h"
#include "server/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

// The corner of `slot` that is not on its edge to `from`.
VertexId vertex_across(const mesh::TriangleMesh& mesh, TriangleId slot, TriangleId from) {
  for (int k = 0; k < 3; ++k) {
    if (mesh.neighbour(slot, k) == from) return mesh.vertices(slot)[static_cast<std::size_t>(k)];
  }
  KERF_CHECK(false, "neighbours are not mutual");
}

// Turned about the edge into the plane, where the edge is at `edge` and the triangle on its left: on its right.
Eigen::Vector2d unfolded(const std::array<Eigen::Vector2d, 2>& edge, const std::array<Eigen::Vector3d, 2>& surface,
                         const Eigen::Vector3d& at) {
  const Eigen::Vector3d along = (surface[1] - surface[0]).normalized();
  const Eigen::Vector3d offset = at - surface[0];
  const double distance = along.dot(offset);
  const double height = (offset - distance * along).norm();
  const Eigen::Vector2d direction = (edge[1] - edge[0]).normalized();
  return edge[0] + distance * direction + height * Eigen::Vector2d(direction.y(), -direction.x());
}

}  // namespace

void Model::set_bending(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten,
                        const std::vector<VertexId>& bereft) {
  for (const VertexId v : bereft) rows_.insert(v);
  // Of a neighbour's patch one vertex is a corner of the rewritten slot.
  patched_.clear();
  for (const TriangleId slot : rewritten) {
    patched_.insert(slot);
    for (int k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(slot, k);
      if (other != mesh::kNone) patched_.insert(other);
    }
  }
  const auto add_rows = [&](const BendingPatch& patch) {
    for (const VertexId v : patch.vertex) {
      if (v != mesh::kNone && v < mesh.num_vertices()) rows_.insert(v);
    }
  };
  for (const TriangleId slot : patched_.members()) {
    BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    add_rows(patch);
    patch = mesh.is_curved() ? make_curved_patch(mesh, slot) : make_patch(mesh, slot);
    add_rows(patch);
  }
  for (const VertexId v : rows_.members()) sum_bending_row(mesh, v);
}

void Model::sum_bending_row(const mesh::TriangleMesh& mesh, VertexId vertex) {
  find_patches_at(mesh, vertex);
  const auto stiffness = [this](std::size_t slot, int a, int b) { return patches_[slot].at(a, b); };
  sum_row(vertex, stiffness, bending_rows_);
  if (rest_bending_.empty()) return;
  const auto bound = [this](std::size_t slot, int a, int b) {
    return std::abs(patches_[slot].at(a, b)) + rest_bending_[slot].excess_at(a, b);
  };
  sum_row(vertex, bound, bound_rows_);
}

void Model::find_patches_at(const mesh::TriangleMesh& mesh, VertexId vertex) {
  std::vector<TriangleId>& slots = row_slots_;
  slots.clear();
  for (const TriangleId slot : incident_.row(vertex)) {
    slots.push_back(slot);
    const std::array<VertexId, 3> vertices = corners(slot);
    const TriangleId across = mesh.neighbour(slot, (vertices[1] == vertex ? 1 : 0) + (vertices[2] == vertex ? 2 : 0));
    if (across != mesh::kNone) slots.push_back(across);
  }
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
}

template <typename Entries>
void Model::sum_row(VertexId vertex, const Entries& entries, RowStore<BendingEntry>& rows) {
  const std::vector<TriangleId>& slots = row_slots_;
  // Hardly any branch below could be predicted, hence few are made.
  if (row_.size() < 6 * slots.size()) row_.resize(6 * slots.size());
  std::size_t size = 0;
  for (const TriangleId slot : slots) {
    const BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    unsigned corners = 0;  // of the patch that are the vertex's: two around a vertex of three triangles
    for (std::size_t a = 0; a < 6; ++a) corners |= (patch.vertex[a] == vertex ? 1U : 0U) << a;
    for (; corners != 0; corners &= corners - 1) {
      const int a = std::countr_zero(corners);
      for (std::size_t b = 0; b < 6; ++b) {
        const VertexId column = patch.vertex[b];
        if (column == mesh::kNone) continue;
        std::int32_t& place = row_place_[static_cast<std::size_t>(column)];
        const bool is_new = place < 0;
        place = is_new ? static_cast<std::int32_t>(size) : place;
        size += is_new ? 1 : 0;
        BendingEntry& entry = row_[static_cast<std::size_t>(place)];
        entry.value = (is_new ? -0.0 : entry.value) +
                      entries(static_cast<std::size_t>(slot), a, static_cast<int>(b));  // -0.0 + x is x, of any sign
        entry.column = column;
      }
    }
  }
  const std::span<BendingEntry> row(row_.data(), size);
  for (const BendingEntry& entry : row) row_place_[static_cast<std::size_t>(entry.column)] = -1;
  std::sort(row.begin(), row.end(), [](const BendingEntry& a, const BendingEntry& b) { return a.column < b.column; });
  rows.set_row(vertex, row);
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
  patch.stiffness = bending_stiffness(X, opposite, has_opposite, bending_law_, inverse_bending_law_);
  return patch;
}

BendingPatch Model::make_curved_patch(const mesh::TriangleMesh& mesh, TriangleId slot) {
  RestBending& rest = rest_bending_[static_cast<std::size_t>(slot)];
  rest = RestBending();
  BendingPatch patch;
  if (!has_material(slot)) return patch;
  const std::array<VertexId, 3> vertices = corners(slot);
  const mesh::Facet* const facet = mesh.facet(slot);
  const Eigen::Matrix2d edges = material_from_rest_ * mesh.rest_edges(slot);
  const std::array<Eigen::Vector2d, 3> X{Eigen::Vector2d::Zero(), edges.col(0), edges.col(1)};
  std::array<Eigen::Vector2d, 3> opposite;
  std::array<bool, 3> has_opposite{};
  std::array<Eigen::Vector3d, 6> surface;  // m
  bool is_bent = false;
  for (std::size_t k = 0; k < 3; ++k) {
    patch.vertex[k] = vertices[k];
    surface[k] = facet->at(mesh.rest_position(vertices[k]));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    opposite[k].setZero();
    surface[3 + k] = surface[0];
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(k));
    if (across == mesh::kNone) continue;
    patch.vertex[3 + k] = vertex_across(mesh, across, slot);
    has_opposite[k] = true;
    is_bent = is_bent || mesh.facet(across) != facet;
    surface[3 + k] = mesh.facet(across)->at(mesh.rest_position(patch.vertex[3 + k]));
    opposite[k] =
        unfolded({X[(k + 1) % 3], X[(k + 2) % 3]}, {surface[(k + 1) % 3], surface[(k + 2) % 3]}, surface[3 + k]);
  }
  patch.stiffness = bending_stiffness(X, opposite, has_opposite, bending_law_, inverse_bending_law_);
  if (is_bent) rest = make_rest_bending(surface, fit_bending(X, opposite, has_opposite, inverse_bending_law_));
  return patch;
}

}  // namespace kerf::fem
