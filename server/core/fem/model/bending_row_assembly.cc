#include "server/core/fem/model/bending_row_assembly.h"

#include <array>
#include <cmath>
#include <utility>

#include "server/core/fem/model/patch_geometry.h"
#include "server/core/linear/rank_ascending.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

// Returns the place of `vertex` in the edge, which must contain it.
std::size_t place_in(const BendingEdge& edge, VertexId vertex) {
  std::size_t place = 0;
  for (std::size_t i = 1; i < 8; ++i) place += edge.vertex[i] == vertex ? i : 0;
  return place;
}

}  // namespace

void BendingRowAssembly::set_row(const Terms& terms, VertexId vertex, linear::RowStore<BendingEntry>& rows,
                                 linear::RowStore<BendingEntry>& bounds) {
  find_patches(terms.sheet, vertex);
  const auto stiffness = [&](std::size_t slot, int a, int b) { return terms.patches[slot].at(a, b); };
  add_patches(terms, stiffness);
  if (terms.edges.num_entries() > 0) add_edges(terms, vertex);
  sum_.move_to(rows, vertex);
  if (terms.rest.empty()) return;
  const auto bound = [&](std::size_t slot, int a, int b) {
    return std::abs(terms.patches[slot].at(a, b)) + terms.rest[slot].excess_at(a, b);
  };
  add_patches(terms, bound);
  sum_.move_to(bounds, vertex);
}

void BendingRowAssembly::find_patches(const RestSheet& sheet, VertexId vertex) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
  found_.clear();
  for (const TriangleId slot : sheet.elements.incident_slots().row(vertex)) {
    const std::array<VertexId, 3> vertices = sheet.elements.corners(slot);
    const int corner = (vertices[1] == vertex ? 1 : 0) + (vertices[2] == vertex ? 2 : 0);
    found_.push_back(8 * slot + corner);
    const TriangleId across = mesh.neighbour(slot, corner);
    if (across == mesh::kNone) continue;
    found_.push_back(8 * across + 3 + static_cast<std::int32_t>(corner_across(mesh, across, slot)));
  }
  linear::rank_ascending(found_, order_);
  patches_.resize(found_.size());
  for (std::size_t i = 0; i < found_.size(); ++i) {
    patches_[static_cast<std::size_t>(order_[i])] = found_[i];
  }
}

template <typename Entry>
void BendingRowAssembly::add_patches(const Terms& terms, const Entry& entry) {
  for (const std::int32_t patch_row : patches_) {
    const auto slot = static_cast<std::size_t>(patch_row / 8);
    std::array<double, 6> row{};
    for (int b = 0; b < 6; ++b) row[static_cast<std::size_t>(b)] = entry(slot, patch_row % 8, b);
    sum_.add(terms.patches[slot].vertex, row);
  }
}

// Adds the edge terms that contain the vertex. One of the two triangles of such an edge has a patch that contains it.
void BendingRowAssembly::add_edges(const Terms& terms, VertexId vertex) {
  constexpr std::size_t kFirstOfSecond = 6;  // place in BendingEdge
  const mesh::TriangleMesh& mesh = terms.sheet.mesh;
  edges_.clear();
  edge_keys_.clear();
  const auto note = [this](TriangleId owner, const BendingEdge& edge, std::size_t place) {
    edge_keys_.push_back(4 * owner + edge.first_edge);
    edges_.push_back({&edge, place});
  };
  TriangleId before = mesh::kNone;
  for (const std::int32_t patch_row : patches_) {
    const TriangleId slot = patch_row / 8;
    if (std::exchange(before, slot) == slot) continue;  // the vertex lies across two edges of the slot
    for (const BendingEdge& edge : terms.edges.row(slot)) note(slot, edge, place_in(edge, vertex));
    if (patch_row % 8 < 3) continue;  // the vertex is a corner: all neighbours are in patches_ too
    for (const TriangleId other : mesh.record(slot).neighbours) {
      if (other == mesh::kNone || other > slot) continue;
      for (const BendingEdge& edge : terms.edges.row(other)) {
        if (mesh.neighbour(other, edge.first_edge) != slot) continue;
        const std::size_t place = place_in(edge, vertex);
        if (place >= kFirstOfSecond) note(other, edge, place);
      }
    }
  }
  linear::rank_ascending(edge_keys_, order_);
  edges_sorted_.resize(edges_.size());
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    edges_sorted_[static_cast<std::size_t>(order_[i])] = edges_[i];
  }
  for (const auto& [edge, a] : edges_sorted_) {
    std::array<double, 8> row{};
    for (std::size_t b = 0; b < 8; ++b) row[b] = edge->at(a, b);
    sum_.add(edge->vertex, row);
  }
}

}  // namespace kerf::fem
