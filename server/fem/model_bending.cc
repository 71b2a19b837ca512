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

// The corner of `slot` that is not on its edge to its neighbour `from`.
std::size_t corner_across(const mesh::TriangleMesh& mesh, TriangleId slot, TriangleId from) {
  const std::array<TriangleId, 3>& neighbours = mesh.record(slot).neighbours;
  return (neighbours[1] == from ? 1U : 0U) + (neighbours[2] == from ? 2U : 0U);
}

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
  const auto set_patch = [&](TriangleId slot) {
    if (!patched_.insert(slot)) return;
    BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    patch = mesh.is_curved() ? make_curved_patch(mesh, slot) : make_patch(mesh, slot);
    for (const VertexId v : patch.vertex) {
      if (v != mesh::kNone) rows_.insert(v);
    }
  };
  for (const TriangleId slot : rewritten) {
    set_patch(slot);
    for (int k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(slot, k);
      if (other != mesh::kNone) set_patch(other);
    }
  }
  for (const VertexId v : rows_.members()) sum_bending_row(mesh, v);
  if (!clamps_.empty() || !clamp_forces_.forces.empty()) sum_clamp_forces(mesh);
}

void Model::set_clamps(const mesh::TriangleMesh& mesh, std::vector<Clamp> clamps) {
  if (!has_bending() || mesh.is_curved()) return;
  std::vector<TriangleId> slots;
  const auto note = [&] {
    for (const Clamp& clamp : clamps_) {
      if (clamp.vertex >= num_vertices()) continue;
      const std::span<const TriangleId> around = incident_.row(clamp.vertex);
      slots.insert(slots.end(), around.begin(), around.end());
    }
  };
  note();
  clamps_ = std::move(clamps);
  note();
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  rows_.clear();
  make_patches(mesh, slots);
  stiffness_bound_.update({blocks_, incident_, bending_rows_, membrane_law_, stiffness_, inverse_mass_}, {}, {},
                          rows_.members());
}

const Clamp* Model::find_clamp(VertexId vertex) const {
  const auto at = std::lower_bound(clamps_.begin(), clamps_.end(), vertex,
                                   [](const Clamp& clamp, VertexId v) { return clamp.vertex < v; });
  return at != clamps_.end() && at->vertex == vertex ? &*at : nullptr;
}

bool Model::find_clamped_edge(const mesh::TriangleMesh& mesh, TriangleId slot, std::size_t k,
                              Eigen::Matrix<double, 3, 2>& gradient) const {
  if (clamps_.empty() || mesh.neighbour(slot, static_cast<int>(k)) != mesh::kNone) return false;
  const std::array<VertexId, 3> vertices = corners(slot);
  const Clamp* const a = find_clamp(vertices[(k + 1) % 3]);
  const Clamp* const b = find_clamp(vertices[(k + 2) % 3]);
  if (a == nullptr || b == nullptr) return false;
  gradient = 0.5 * (a->gradient + b->gradient);
  return true;
}

void Model::sum_clamp_forces(const mesh::TriangleMesh& mesh) {
  clamp_forces_ = {};
  std::vector<TriangleId> slots;
  for (const Clamp& clamp : clamps_) {
    const std::span<const TriangleId> around = incident_.row(clamp.vertex);
    slots.insert(slots.end(), around.begin(), around.end());
  }
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  for (const TriangleId slot : slots) {
    const BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    const std::array<VertexId, 3> vertices = corners(slot);
    std::array<Eigen::Vector2d, 3> X;
    for (std::size_t k = 0; k < 3; ++k) X[k] = mesh.rest_position(vertices[k]);
    // What the clamps hold, h x_nu, in place of the vertices across.
    std::array<Eigen::Vector3d, 3> held;
    held.fill(Eigen::Vector3d::Zero());
    for (std::size_t k = 0; k < 3; ++k) {
      Eigen::Matrix<double, 3, 2> gradient;
      if (find_clamped_edge(mesh, slot, k, gradient)) held[k] = gradient * clamp_arm(X, k);
    }
    for (int a = 0; a < 6; ++a) {
      Eigen::Vector3d pull = Eigen::Vector3d::Zero();
      for (int k = 0; k < 3; ++k) pull -= patch.at(a, 3 + k) * held[static_cast<std::size_t>(k)];
      const VertexId vertex = patch.vertex[static_cast<std::size_t>(a)];
      if (vertex != mesh::kNone) {
        if (!pull.isZero(0.0)) clamp_forces_.forces.push_back({vertex, pull});
      } else if (a >= 3) {
        clamp_forces_.energy -= 0.5 * pull.dot(held[static_cast<std::size_t>(a - 3)]);
      }
    }
  }
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

template <typename Entries>
void Model::sum_row(VertexId vertex, const Entries& entries, RowStore<BendingEntry>& rows) {
  // Hardly any branch below could be predicted, hence few are made: what a missing vertex has goes to place 0.
  const std::size_t most = 1 + 6 * row_sorted_.size();
  if (row_values_.size() < most) row_values_.resize(most), row_columns_.resize(most);
  std::int32_t* const place_of = row_place_.data() + 1;
  std::int32_t size = 1;
  for (const std::int32_t patch_row : row_sorted_) {
    const auto slot = static_cast<std::size_t>(patch_row / 8);
    const BendingPatch& patch = patches_[slot];
    for (int b = 0; b < 6; ++b) {
      const VertexId column = patch.vertex[static_cast<std::size_t>(b)];
      const bool is_new = place_of[column] < 0;
      const std::int32_t place = is_new ? size : place_of[column];
      size += is_new ? 1 : 0;
      place_of[column] = place;
      row_columns_[static_cast<std::size_t>(place)] = column;
      double& value = row_values_[static_cast<std::size_t>(place)];
      value = (is_new ? -0.0 : value) + entries(slot, patch_row % 8, b);  // -0.0 + x is x, of any sign
    }
  }
  const std::span<const VertexId> columns(row_columns_.data() + 1, static_cast<std::size_t>(size - 1));
  place_in_order(columns, row_order_);
  row_.resize(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    row_[row_order_[i]] = {row_values_[1 + i], columns[i]};
    place_of[columns[i]] = -1;
  }
  rows.set_row(vertex, row_);
}

BendingPatch Model::make_patch(const mesh::TriangleMesh& mesh, TriangleId slot) const {
  BendingPatch patch;
  if (!has_material(slot)) return patch;
  const std::array<VertexId, 3> vertices = corners(slot);
  std::array<Eigen::Vector2d, 3> X;
  std::array<Eigen::Vector2d, 3> opposite;
  std::array<PatchEdge, 3> edges{};
  for (std::size_t k = 0; k < 3; ++k) {
    patch.vertex[k] = vertices[k];
    X[k] = material_from_rest_ * mesh.rest_position(vertices[k]);
    opposite[k].setZero();
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(k));
    if (across == mesh::kNone) {
      Eigen::Matrix<double, 3, 2> gradient;
      if (find_clamped_edge(mesh, slot, k, gradient)) edges[k] = PatchEdge::kClamped;
      continue;
    }
    patch.vertex[3 + k] = mesh.vertices(across)[corner_across(mesh, across, slot)];
    opposite[k] = material_from_rest_ * mesh.rest_position(patch.vertex[3 + k]);
    edges[k] = PatchEdge::kNeighbour;
  }
  patch.stiffness = bending_stiffness(X, opposite, edges, inverse_bending_law_);
  return patch;
}

EdgeMoment Model::edge_moment(const mesh::TriangleMesh& mesh, TriangleId slot, int edge,
                              double moment_per_length) const {
  KERF_CHECK(has_material(slot) && mesh.neighbour(slot, edge) == mesh::kNone, "a border edge of a solid triangle");
  const auto k = static_cast<std::size_t>(edge);
  const Eigen::Matrix2d sides = material_from_rest_ * mesh.rest_edges(slot);
  const std::array<Eigen::Vector2d, 3> X{Eigen::Vector2d::Zero(), sides.col(0), sides.col(1)};
  const bool is_flat = has_bending() && !mesh.is_curved();
  EdgeMoment made;
  made.edge = k;
  made.arm = clamp_arm(X, k).norm();
  made.moment = moment_per_length * (X[(k + 2) % 3] - X[(k + 1) % 3]).norm();
  const std::array<VertexId, 3> vertices = corners(slot);
  std::array<Eigen::Vector2d, 3> opposite;
  std::array<PatchEdge, 3> edges{};
  for (std::size_t i = 0; i < 3; ++i) {
    made.vertex[i] = vertices[i];
    opposite[i].setZero();
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(i));
    if (!is_flat || across == mesh::kNone) continue;
    made.vertex[3 + i] = mesh.vertices(across)[corner_across(mesh, across, slot)];
    opposite[i] = material_from_rest_ * (mesh.rest_position(made.vertex[3 + i]) - mesh.rest_position(vertices[0]));
    edges[i] = PatchEdge::kNeighbour;
  }
  Eigen::Matrix<double, 3, 2> held;
  if (find_clamped_edge(mesh, slot, k, held)) return made;
  edges[k] = PatchEdge::kClamped;
  const BendingFit fit =
      fit_bending(X, opposite, edges, has_bending() ? inverse_bending_law_ : Eigen::Matrix3d::Identity());
  // Of the conditions w = W x the one of the edge has the slope in it, arm x_nu - L x, and takes the value at which
  // the energy w.law w / 2 is least, the others being what they are.
  const auto row = static_cast<Eigen::Index>(k);
  constexpr double kLeastLaw = 1e-3;  // -; below it the others leave the slope open
  const bool is_coupled = fit.law(row, row) > kLeastLaw * fit.law.trace();
  for (Eigen::Index a = 0; a < 6; ++a) {
    if (a == 3 + row) continue;
    double weight = -fit.conditions(row, a);
    for (Eigen::Index r = 0; is_coupled && r < 3; ++r) {
      if (r != row) weight -= fit.law(row, r) / fit.law(row, row) * fit.conditions(r, a);
    }
    made.weight[static_cast<std::size_t>(a)] = weight;
  }
  return made;
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
  std::array<PatchEdge, 3> across_edge{};
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
    patch.vertex[3 + k] = mesh.vertices(across)[corner_across(mesh, across, slot)];
    across_edge[k] = PatchEdge::kNeighbour;
    is_bent = is_bent || mesh.facet(across) != facet;
    surface[3 + k] = mesh.facet(across)->at(mesh.rest_position(patch.vertex[3 + k]));
    opposite[k] =
        unfolded({X[(k + 1) % 3], X[(k + 2) % 3]}, {surface[(k + 1) % 3], surface[(k + 2) % 3]}, surface[3 + k]);
  }
  patch.stiffness = bending_stiffness(X, opposite, across_edge, inverse_bending_law_);
  if (is_bent) rest = make_rest_bending(surface, fit_bending(X, opposite, across_edge, inverse_bending_law_));
  return patch;
}

}  // namespace kerf::fem
