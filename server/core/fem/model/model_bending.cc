// The bending part of Model.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "server/base/check.h"
#include "server/base/interruption.h"
#include "server/core/fem/element/bending_lanes.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

constexpr std::size_t kMostFitsKept = 4096;  // kept from one edit to the next; the fits of a whole sheet are not kept

// Returns the surface point `at` turned about the edge into the plane, to the right of the edge. The plane edge is
// `edge`, with the triangle on its left.
Eigen::Vector2d unfolded(const std::array<Eigen::Vector2d, 2>& edge, const std::array<Eigen::Vector3d, 2>& surface,
                         const Eigen::Vector3d& at) {
  const Eigen::Vector3d along = (surface[1] - surface[0]).normalized();
  const Eigen::Vector3d offset = at - surface[0];
  const double distance = along.dot(offset);
  const double height = (offset - distance * along).norm();
  const Eigen::Vector2d direction = (edge[1] - edge[0]).normalized();
  return edge[0] + distance * direction + height * Eigen::Vector2d(direction.y(), -direction.x());
}

// Returns the place of `vertex` in the edge, which must contain it.
std::size_t place_in(const BendingEdge& edge, VertexId vertex) {
  std::size_t place = 0;
  for (std::size_t i = 1; i < 8; ++i) place += edge.vertex[i] == vertex ? i : 0;
  return place;
}

// Calls visit(t) for each slot and its neighbours; may repeat.
template <typename Visit>
void for_each_with_neighbours(const mesh::TriangleMesh& mesh, std::span<const TriangleId> slots, const Visit& visit) {
  for (const TriangleId slot : slots) {
    visit(slot);
    for (int k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(slot, k);
      if (other != mesh::kNone) visit(other);
    }
  }
}

}  // namespace

void Model::set_bending(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten) {
  // A vertex that a patch has lost was a corner of a rewritten slot: a triangle is rewritten with its neighbours.
  for (const VertexId v : touched_.members()) rows_.insert(v);
  make_patches(mesh, rewritten);
}

void Model::make_patches(const mesh::TriangleMesh& mesh, std::span<const TriangleId> rewritten) {
  angle_bending_.reset();
  patched_.clear();
  fitted_.clear();
  for_each_with_neighbours(mesh, rewritten, [&](TriangleId slot) {
    if (!patched_.insert(slot)) return;
    fitted_.insert(slot);
    BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    // A patch whose triangle does not bend still has vertices: they are columns of the matrix.
    patch.vertex = patch_vertices(mesh, slot);
    patch.stiffness.fill(0.0);
    if (mesh.is_curved()) rest_bending_[static_cast<std::size_t>(slot)] = RestBending();
    mark_rows(patch.vertex);
  });
  if (!mesh.is_curved()) {  // moments on kinks also need the patches across edges
    for_each_with_neighbours(mesh, patched_.members(), [&](TriangleId slot) { fitted_.insert(slot); });
  }
  fit_patches(mesh);
  if (!mesh.is_curved()) make_edges(mesh);
  for (const VertexId v : rows_.members()) {
    interruption_point();
    sum_bending_row(mesh, v);
  }
  if (sides_.size() > kMostFitsKept) sides_ = {};
  if (!clamps_.empty() || !clamp_forces_.forces.empty()) sum_clamp_forces(mesh);
}

void Model::fit_patches(const mesh::TriangleMesh& mesh) {
  if (!mesh.is_curved() && sides_.size() < fitted_.size()) sides_.resize(fitted_.size());
  PatchLanes lanes;
  std::array<TriangleId, kBlockLanes> slots{};
  std::array<PatchSurface, kBlockLanes> surfaces;
  std::size_t count = 0;
  const auto fit = [&] {
    lanes.fit(count);
    for (std::size_t l = 0; l < count; ++l) {
      const auto slot = static_cast<std::size_t>(slots[l]);
      if (patched_.contains(slots[l])) patches_[slot].stiffness = lanes.stiffness_of(l);
      if (surfaces[l].is_bent) rest_bending_[slot] = make_rest_bending(surfaces[l].at, lanes.fit_of(l));
      if (mesh.is_curved()) continue;
      std::array<BendingSide, 3>& sides = sides_[static_cast<std::size_t>(fitted_.place(slots[l]))];
      for (std::size_t k = 0; k < 3; ++k) sides[k] = lanes.side_of(l, k);
    }
    count = 0;
  };
  for (const TriangleId slot : fitted_.members()) {
    interruption_point();
    if (!has_material(slot) || !law(slot).has_bending()) continue;
    const PatchGeometry patch = mesh.is_curved() ? curved_patch(mesh, slot, surfaces[count]) : flat_patch(mesh, slot);
    lanes.set(count, patch, law(slot).bending, law(slot).inverse_bending);
    slots[count++] = slot;
    if (count == kBlockLanes) fit();
  }
  if (count > 0) fit();
}

void Model::mark_rows(std::span<const VertexId> vertices) {
  for (const VertexId v : vertices) {
    if (v != mesh::kNone && v < num_vertices()) rows_.insert(v);
  }
}

void Model::make_edges(const mesh::TriangleMesh& mesh) {
  edged_.clear();
  for (const TriangleId slot : patched_.members()) {
    edged_.insert(slot);
    for (int k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(slot, k);
      if (other != mesh::kNone && other < slot) edged_.insert(other);
    }
  }
  for (const TriangleId slot : edged_.members()) {
    interruption_point();
    const std::span<const BendingEdge> before = bending_edges_.row(slot);
    edge_row_.clear();
    for (int k = 0; k < 3; ++k) {
      const auto old =
          std::find_if(before.begin(), before.end(), [&](const auto& edge) { return edge.first_edge == k; });
      const TriangleId other = has_material(slot) ? mesh.neighbour(slot, k) : mesh::kNone;
      const bool is_kept = other != mesh::kNone && !patched_.contains(slot) && !patched_.contains(other);
      if (!is_kept && old != before.end()) mark_rows(old->vertex);
      if (is_kept && old != before.end()) edge_row_.push_back(*old);
      if (is_kept || other < slot) continue;
      BendingEdge edge;
      if (!make_edge(mesh, slot, other, k, edge)) continue;
      edge_row_.push_back(edge);
      mark_rows(edge.vertex);
    }
    if (!before.empty() || !edge_row_.empty()) bending_edges_.set_row(slot, edge_row_);
  }
}

bool Model::make_edge(const mesh::TriangleMesh& mesh, TriangleId slot, TriangleId other, int k, BendingEdge& edge) {
  if (!law(slot).has_bending() || !law(other).has_bending()) return false;  // no moment crosses the edge
  const auto first = static_cast<std::size_t>(k);
  const std::size_t second = corner_across(mesh, other, slot);
  const std::array<std::size_t, 6> places = places_of_second(first, second);
  edge.first_edge = k;
  edge.material = {material_at(mesh, slot), material_at(mesh, other)};
  const std::array<VertexId, 6>& mine = patches_[static_cast<std::size_t>(slot)].vertex;
  const std::array<VertexId, 6>& theirs = patches_[static_cast<std::size_t>(other)].vertex;
  std::copy(mine.begin(), mine.end(), edge.vertex.begin());
  for (std::size_t i = 0; i < 6; ++i) edge.vertex[places[i]] = theirs[i];
  const auto side = [&](TriangleId at, std::size_t opposite) -> const BendingSide& {
    return sides_[static_cast<std::size_t>(fitted_.place(at))][opposite];
  };
  return join_sides(side(slot, first), side(other, second), places, edge);
}

void Model::sum_bending_row(const mesh::TriangleMesh& mesh, VertexId vertex) {
  find_patches_at(mesh, vertex);
  const auto stiffness = [this](std::size_t slot, int a, int b) { return patches_[slot].at(a, b); };
  add_patches_to_row(stiffness);
  if (bending_edges_.num_entries() > 0) add_edges_to_row(mesh, vertex);
  row_sum_.move_to(bending_rows_, vertex);
  if (rest_bending_.empty()) return;
  const auto bound = [this](std::size_t slot, int a, int b) {
    return std::abs(patches_[slot].at(a, b)) + rest_bending_[slot].excess_at(a, b);
  };
  add_patches_to_row(bound);
  row_sum_.move_to(bound_rows_, vertex);
}

void Model::find_patches_at(const mesh::TriangleMesh& mesh, VertexId vertex) {
  row_patches_.clear();
  for (const TriangleId slot : incident_.row(vertex)) {
    const std::array<VertexId, 3> vertices = corners(slot);
    const int corner = (vertices[1] == vertex ? 1 : 0) + (vertices[2] == vertex ? 2 : 0);
    row_patches_.push_back(8 * slot + corner);
    const TriangleId across = mesh.neighbour(slot, corner);
    if (across == mesh::kNone) continue;
    row_patches_.push_back(8 * across + 3 + static_cast<std::int32_t>(corner_across(mesh, across, slot)));
  }
  place_in_order(row_patches_, row_order_);
  row_sorted_.resize(row_patches_.size());
  for (std::size_t i = 0; i < row_patches_.size(); ++i) {
    row_sorted_[static_cast<std::size_t>(row_order_[i])] = row_patches_[i];
  }
}

template <typename Entries>
void Model::add_patches_to_row(const Entries& entries) {
  for (const std::int32_t patch_row : row_sorted_) {
    const auto slot = static_cast<std::size_t>(patch_row / 8);
    std::array<double, 6> row{};
    for (int b = 0; b < 6; ++b) row[static_cast<std::size_t>(b)] = entries(slot, patch_row % 8, b);
    row_sum_.add(patches_[slot].vertex, row);
  }
}

// An edge term that contains the vertex belongs to a triangle whose patch contains it.
void Model::add_edges_to_row(const mesh::TriangleMesh& mesh, VertexId vertex) {
  constexpr std::size_t kFirstOfSecond = 6;  // place in BendingEdge
  row_edges_.clear();
  row_keys_.clear();
  const auto note = [this](TriangleId owner, const BendingEdge& edge, std::size_t place) {
    row_keys_.push_back(4 * owner + edge.first_edge);
    row_edges_.push_back({&edge, place});
  };
  TriangleId before = mesh::kNone;
  for (const std::int32_t patch_row : row_sorted_) {
    const TriangleId slot = patch_row / 8;
    if (std::exchange(before, slot) == slot) continue;  // across two edges
    for (const BendingEdge& edge : bending_edges_.row(slot)) note(slot, edge, place_in(edge, vertex));
    if (patch_row % 8 < 3) continue;  // the patches of all its neighbours contain the vertex
    for (const TriangleId other : mesh.record(slot).neighbours) {
      if (other == mesh::kNone || other > slot) continue;
      for (const BendingEdge& edge : bending_edges_.row(other)) {
        if (mesh.neighbour(other, edge.first_edge) != slot) continue;
        const std::size_t place = place_in(edge, vertex);
        if (place >= kFirstOfSecond) note(other, edge, place);
      }
    }
  }
  place_in_order(row_keys_, row_order_);
  row_edges_sorted_.resize(row_edges_.size());
  for (std::size_t i = 0; i < row_edges_.size(); ++i) {
    row_edges_sorted_[static_cast<std::size_t>(row_order_[i])] = row_edges_[i];
  }
  for (const auto& [edge, a] : row_edges_sorted_) {
    std::array<double, 8> row{};
    for (std::size_t b = 0; b < 8; ++b) row[b] = edge->at(a, b);
    row_sum_.add(edge->vertex, row);
  }
}

std::size_t Model::corner_across(const mesh::TriangleMesh& mesh, TriangleId slot, TriangleId from) {
  const std::array<TriangleId, 3>& neighbours = mesh.record(slot).neighbours;
  return (neighbours[1] == from ? 1U : 0U) + (neighbours[2] == from ? 2U : 0U);
}

std::array<VertexId, 6> Model::patch_vertices(const mesh::TriangleMesh& mesh, TriangleId slot) const {
  std::array<VertexId, 6> made;
  made.fill(mesh::kNone);
  if (!has_material(slot)) return made;
  const std::array<VertexId, 3> vertices = corners(slot);
  for (std::size_t k = 0; k < 3; ++k) {
    made[k] = vertices[k];
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(k));
    if (across != mesh::kNone) made[3 + k] = mesh.vertices(across)[corner_across(mesh, across, slot)];
  }
  return made;
}

PatchGeometry Model::flat_patch(const mesh::TriangleMesh& mesh, TriangleId slot) const {
  const std::array<VertexId, 6> vertex = patch_vertices(mesh, slot);
  const Eigen::Matrix2d& axes = law(slot).axes;
  PatchGeometry patch;
  for (std::size_t k = 0; k < 3; ++k) {
    patch.corners[k] = axes * mesh.rest_position(vertex[k]);
    patch.opposite[k].setZero();
    if (vertex[3 + k] != mesh::kNone) {
      patch.opposite[k] = axes * mesh.rest_position(vertex[3 + k]);
      patch.edges[k] = PatchEdge::kNeighbour;
      continue;
    }
    Eigen::Matrix<double, 3, 2> gradient;
    if (find_clamped_edge(mesh, slot, k, gradient)) patch.edges[k] = PatchEdge::kClamped;
  }
  return patch;
}

PatchGeometry Model::curved_patch(const mesh::TriangleMesh& mesh, TriangleId slot, PatchSurface& surface) const {
  const mesh::Facet* const facet = mesh.facet(slot);
  const Eigen::Matrix2d edges = law(slot).axes * mesh.rest_edges(slot);
  PatchGeometry patch{{Eigen::Vector2d::Zero(), edges.col(0), edges.col(1)}, {}, {}};
  const std::array<Eigen::Vector2d, 3>& X = patch.corners;
  std::array<Eigen::Vector3d, 6>& at = surface.at;
  surface.is_bent = false;
  const std::array<VertexId, 6> vertex = patch_vertices(mesh, slot);
  for (std::size_t k = 0; k < 3; ++k) at[k] = facet->at(mesh.rest_position(vertex[k]));
  for (std::size_t k = 0; k < 3; ++k) {
    patch.opposite[k].setZero();
    at[3 + k] = at[0];
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(k));
    if (across == mesh::kNone) continue;
    patch.edges[k] = PatchEdge::kNeighbour;
    surface.is_bent = surface.is_bent || mesh.facet(across) != facet;
    at[3 + k] = mesh.facet(across)->at(mesh.rest_position(vertex[3 + k]));
    patch.opposite[k] = unfolded({X[(k + 1) % 3], X[(k + 2) % 3]}, {at[(k + 1) % 3], at[(k + 2) % 3]}, at[3 + k]);
  }
  return patch;
}

}  // namespace kerf::fem
