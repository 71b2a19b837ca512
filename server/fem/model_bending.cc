// The bending part of Model.
#include <algorithm>
#include <array>
#include <cmath>

#include "server/base/check.h"
#include "server/fem/model.h"
#include "server/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

constexpr std::size_t kMostFitsKept = 4096;  // from one edit to the next; those of a whole sheet are not

// The place of each of some different keys in ascending order. Of few it is counted as the number of keys below:
// without a branch that could not be predicted.
void place_in_order(std::span<const std::int32_t> keys, std::vector<std::uint32_t>& places) {
  constexpr std::size_t kFew = 64;
  const std::size_t size = keys.size();
  places.assign(size, 0);
  if (size <= kFew) {
    for (const std::int32_t key : keys) {
      for (std::size_t i = 0; i < size; ++i) places[i] += key < keys[i] ? 1U : 0U;
    }
    return;
  }
  std::vector<std::int32_t> sorted(keys.begin(), keys.end());
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < size; ++i) {
    places[i] = static_cast<std::uint32_t>(std::lower_bound(sorted.begin(), sorted.end(), keys[i]) - sorted.begin());
  }
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

void Model::set_bending(const mesh::TriangleMesh& mesh, const std::vector<TriangleId>& rewritten) {
  // A vertex that a patch has lost was a corner of a rewritten slot: a triangle is rewritten with its neighbours.
  for (const VertexId v : touched_.members()) rows_.insert(v);
  make_patches(mesh, rewritten);
}

void Model::make_patches(const mesh::TriangleMesh& mesh, std::span<const TriangleId> rewritten) {
  patched_.clear();
  fitted_.clear();
  const auto set_patch = [&](TriangleId slot) {
    if (!patched_.insert(slot)) return;
    BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    if (mesh.is_curved()) {
      patch = make_curved_patch(mesh, slot);
    } else {
      patch.vertex = patch_vertices(mesh, slot);
      // Where its triangle does not bend a patch has its vertices none the less: they are columns of the matrix.
      const bool bends = has_material(slot) && law(slot).has_bending();
      patch.stiffness = bends ? bending_stiffness(fit_at(mesh, slot).fit) : std::array<double, 21>{};
    }
    mark_rows(patch.vertex);
  };
  for (const TriangleId slot : rewritten) {
    set_patch(slot);
    for (int k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(slot, k);
      if (other != mesh::kNone) set_patch(other);
    }
  }
  if (!mesh.is_curved()) make_edges(mesh);
  for (const VertexId v : rows_.members()) sum_bending_row(mesh, v);
  if (fits_.size() > kMostFitsKept) fits_ = {};
  if (!clamps_.empty() || !clamp_forces_.forces.empty()) sum_clamp_forces(mesh);
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
  if (!law(slot).has_bending() || !law(other).has_bending()) return false;  // no moment crosses it
  const auto first = static_cast<std::size_t>(k);
  const std::size_t second = corner_across(mesh, other, slot);
  const std::array<std::size_t, 6> places = places_of_second(first, second);
  edge.first_edge = k;
  edge.material = {material_at(mesh, slot), material_at(mesh, other)};
  const std::array<VertexId, 6> mine = patch_vertices(mesh, slot);
  const std::array<VertexId, 6> theirs = patch_vertices(mesh, other);
  std::copy(mine.begin(), mine.end(), edge.vertex.begin());
  for (std::size_t i = 0; i < 6; ++i) edge.vertex[places[i]] = theirs[i];
  const auto side = [&](TriangleId at, std::size_t opposite) {
    const PatchFit& patch = fit_at(mesh, at);
    return bending_side(patch.geometry, patch.fit, law(at).bending, law(at).inverse_bending, opposite);
  };
  const BendingSide from = side(slot, first);
  return join_sides(from, side(other, second), places, edge);
}

void Model::sum_bending_row(const mesh::TriangleMesh& mesh, VertexId vertex) {
  find_patches_at(mesh, vertex);
  const auto stiffness = [this](std::size_t slot, int a, int b) { return patches_[slot].at(a, b); };
  add_patches_to_row(stiffness);
  if (bending_edges_.num_entries() > 0) add_edges_to_row(mesh, vertex);
  finish_row(vertex, bending_rows_);
  if (rest_bending_.empty()) return;
  const auto bound = [this](std::size_t slot, int a, int b) {
    return std::abs(patches_[slot].at(a, b)) + rest_bending_[slot].excess_at(a, b);
  };
  add_patches_to_row(bound);
  finish_row(vertex, bound_rows_);
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
  for (std::size_t i = 0; i < row_patches_.size(); ++i) row_sorted_[row_order_[i]] = row_patches_[i];
}

void Model::reserve_row(std::size_t more) {
  const std::size_t most = static_cast<std::size_t>(row_size_) + more;
  if (row_values_.size() < most) row_values_.resize(most), row_columns_.resize(most);
}

// Hardly any branch below could be predicted, hence none is made: what a missing vertex has goes to place 0.
void Model::add_to_row(VertexId column, double entry) {
  std::int32_t* const place_of = row_place_.data() + 1;
  const bool is_new = place_of[column] < 0;
  const std::int32_t place = is_new ? row_size_ : place_of[column];
  row_size_ += is_new ? 1 : 0;
  place_of[column] = place;
  row_columns_[static_cast<std::size_t>(place)] = column;
  double& value = row_values_[static_cast<std::size_t>(place)];
  value = (is_new ? -0.0 : value) + entry;  // -0.0 + x is x, of any sign
}

template <typename Entries>
void Model::add_patches_to_row(const Entries& entries) {
  reserve_row(6 * row_sorted_.size());
  for (const std::int32_t patch_row : row_sorted_) {
    const auto slot = static_cast<std::size_t>(patch_row / 8);
    const BendingPatch& patch = patches_[slot];
    for (int b = 0; b < 6; ++b) add_to_row(patch.vertex[static_cast<std::size_t>(b)], entries(slot, patch_row % 8, b));
  }
}

// An edge that the vertex has a part in is one of a triangle whose patch the vertex is in.
void Model::add_edges_to_row(const mesh::TriangleMesh& mesh, VertexId vertex) {
  row_owners_.clear();
  for (const std::int32_t patch_row : row_sorted_) {
    const TriangleId slot = patch_row / 8;
    if (!bending_edges_.row(slot).empty()) row_owners_.push_back(slot);
    for (int k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(slot, k);
      if (other != mesh::kNone && other < slot && !bending_edges_.row(other).empty()) row_owners_.push_back(other);
    }
  }
  std::sort(row_owners_.begin(), row_owners_.end());
  row_owners_.erase(std::unique(row_owners_.begin(), row_owners_.end()), row_owners_.end());
  reserve_row(24 * row_owners_.size());
  for (const TriangleId owner : row_owners_) {
    for (const BendingEdge& edge : bending_edges_.row(owner)) {
      const auto at = std::find(edge.vertex.begin(), edge.vertex.end(), vertex);
      if (at == edge.vertex.end()) continue;
      const auto a = static_cast<std::size_t>(at - edge.vertex.begin());
      for (std::size_t b = 0; b < 8; ++b) add_to_row(edge.vertex[b], edge.at(a, b));
    }
  }
}

void Model::finish_row(VertexId vertex, RowStore<BendingEntry>& rows) {
  const std::span<const VertexId> columns(row_columns_.data() + 1, static_cast<std::size_t>(row_size_ - 1));
  place_in_order(columns, row_order_);
  row_.resize(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    row_[row_order_[i]] = {row_values_[1 + i], columns[i]};
    row_place_[static_cast<std::size_t>(columns[i] + 1)] = -1;
  }
  row_size_ = 1;
  rows.set_row(vertex, row_);
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

const Model::PatchFit& Model::fit_at(const mesh::TriangleMesh& mesh, TriangleId slot) {
  if (fitted_.contains(slot)) return fits_[static_cast<std::size_t>(fitted_.place(slot))];
  fitted_.insert(slot);
  if (fits_.size() < fitted_.size()) fits_.resize(fitted_.size());
  PatchFit& made = fits_[fitted_.size() - 1];
  const std::array<VertexId, 6> vertex = patch_vertices(mesh, slot);
  const MaterialLaw& own = law(slot);
  for (std::size_t k = 0; k < 3; ++k) {
    made.geometry.corners[k] = own.axes * mesh.rest_position(vertex[k]);
    made.geometry.opposite[k].setZero();
    made.geometry.edges[k] = PatchEdge::kFree;
    if (vertex[3 + k] != mesh::kNone) {
      made.geometry.opposite[k] = own.axes * mesh.rest_position(vertex[3 + k]);
      made.geometry.edges[k] = PatchEdge::kNeighbour;
      continue;
    }
    Eigen::Matrix<double, 3, 2> gradient;
    if (find_clamped_edge(mesh, slot, k, gradient)) made.geometry.edges[k] = PatchEdge::kClamped;
  }
  made.fit = fit_bending(made.geometry, own.inverse_bending);
  return made;
}

BendingPatch Model::make_curved_patch(const mesh::TriangleMesh& mesh, TriangleId slot) {
  RestBending& rest = rest_bending_[static_cast<std::size_t>(slot)];
  rest = RestBending();
  BendingPatch patch;
  if (!has_material(slot)) return patch;
  const mesh::Facet* const facet = mesh.facet(slot);
  const MaterialLaw& own = law(slot);
  const Eigen::Matrix2d edges = own.axes * mesh.rest_edges(slot);
  PatchGeometry geometry{{Eigen::Vector2d::Zero(), edges.col(0), edges.col(1)}, {}, {}};
  const std::array<Eigen::Vector2d, 3>& X = geometry.corners;
  std::array<Eigen::Vector3d, 6> surface;  // m
  bool is_bent = false;
  patch.vertex = patch_vertices(mesh, slot);
  for (std::size_t k = 0; k < 3; ++k) surface[k] = facet->at(mesh.rest_position(patch.vertex[k]));
  for (std::size_t k = 0; k < 3; ++k) {
    geometry.opposite[k].setZero();
    surface[3 + k] = surface[0];
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(k));
    if (across == mesh::kNone) continue;
    geometry.edges[k] = PatchEdge::kNeighbour;
    is_bent = is_bent || mesh.facet(across) != facet;
    surface[3 + k] = mesh.facet(across)->at(mesh.rest_position(patch.vertex[3 + k]));
    geometry.opposite[k] =
        unfolded({X[(k + 1) % 3], X[(k + 2) % 3]}, {surface[(k + 1) % 3], surface[(k + 2) % 3]}, surface[3 + k]);
  }
  if (!own.has_bending()) return patch;
  const BendingFit fit = fit_bending(geometry, own.inverse_bending);
  patch.stiffness = bending_stiffness(fit);
  if (is_bent) rest = make_rest_bending(surface, fit);
  return patch;
}

}  // namespace kerf::fem
