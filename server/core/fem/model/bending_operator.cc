#include "server/core/fem/model/bending_operator.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/base/interruption.h"
#include "server/base/sort_unique.h"
#include "server/base/state_hash.h"
#include "server/core/fem/element/angle_bending.h"
#include "server/core/fem/element/bending_lanes.h"
#include "server/core/fem/model/angle_assembly.h"
#include "server/core/fem/model/patch_geometry.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

constexpr std::size_t kMostFitsKept = 4096;  // kept from one edit to the next; the fits of a whole sheet are not kept

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

void BendingOperator::make_room() {
  rows_.make_room();
  bound_rows_.make_room();
}

void BendingOperator::follow(const RestSheet& sheet, std::span<const TriangleId> rewritten) {
  changed_rows_.clear();
  if (!sheet.elements.materials().has_bending()) return;
  resize(sheet);
  // A vertex that a patch has lost was a corner of a rewritten slot: a triangle is rewritten with its neighbours.
  for (const VertexId v : sheet.elements.touched().members()) changed_rows_.insert(v);
  make_patches(sheet, rewritten);
}

void BendingOperator::resize(const RestSheet& sheet) {
  const auto num_slots = static_cast<std::size_t>(sheet.elements.num_slots());
  const int num_vertices = sheet.elements.num_vertices();
  patched_.resize(num_slots);
  changed_rows_.resize(static_cast<std::size_t>(num_vertices));
  assembly_.resize(static_cast<std::size_t>(num_vertices));
  patches_.resize(num_slots);
  rows_.resize(num_vertices);
  edged_.resize(num_slots);
  fitted_.resize(num_slots);
  edges_.resize(sheet.elements.num_slots());
  if (!sheet.mesh.is_curved()) return;
  rest_.resize(num_slots);
  bound_rows_.resize(num_vertices);
}

bool BendingOperator::set_clamps(const RestSheet& sheet, BorderClamps clamps) {
  if (!sheet.elements.materials().has_bending() || sheet.mesh.is_curved()) return false;
  std::vector<TriangleId> slots;
  clamps_.add_slots(sheet.elements, slots);
  clamps_ = std::move(clamps);
  clamps_.add_slots(sheet.elements, slots);
  sort_unique(slots);
  changed_rows_.clear();
  make_patches(sheet, slots);
  return true;
}

void BendingOperator::bend_by_angles(const RestSheet& sheet) {
  if (angles_ != nullptr || !sheet.elements.materials().has_bending() || sheet.mesh.is_curved()) return;
  patched_.clear();
  fitted_.clear();
  for (TriangleId slot = 0; slot < sheet.elements.num_slots(); ++slot) fitted_.insert(slot);  // its place is the slot
  fit_patches(sheet);
  angles_ = std::make_shared<AngleBending>(make_angle_bending(sheet, clamps_, patches_, edges_, sides_));
  sides_ = {};
}

void BendingOperator::make_patches(const RestSheet& sheet, std::span<const TriangleId> slots) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
  angles_.reset();
  patched_.clear();
  fitted_.clear();
  for_each_with_neighbours(mesh, slots, [&](TriangleId slot) {
    if (!patched_.insert(slot)) return;
    fitted_.insert(slot);
    BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    // A patch whose triangle does not bend still has vertices: they are columns of the matrix.
    patch.vertex = patch_vertices(sheet, slot);
    patch.stiffness.fill(0.0);
    if (mesh.is_curved()) rest_[static_cast<std::size_t>(slot)] = RestBending();
    mark_rows(patch.vertex);
  });
  if (!mesh.is_curved()) {  // moments on kinks also need the patches across edges
    for_each_with_neighbours(mesh, patched_.members(), [&](TriangleId slot) { fitted_.insert(slot); });
  }
  fit_patches(sheet);
  if (!mesh.is_curved()) make_edges(sheet);
  const BendingRowAssembly::Terms terms{sheet, patches_, edges_, rest_};
  for (const VertexId v : changed_rows_.members()) {
    interruption_point();
    assembly_.set_row(terms, v, rows_, bound_rows_);
  }
  if (sides_.size() > kMostFitsKept) sides_ = {};
  if (!clamps_.empty() || !clamp_forces_.forces.empty()) {
    clamp_forces_ = make_clamp_forces(sheet, clamps_, patches_, edges_);
  }
}

void BendingOperator::fit_patches(const RestSheet& sheet) {
  if (!sheet.mesh.is_curved() && sides_.size() < fitted_.size()) sides_.resize(fitted_.size());
  PatchLanes lanes;
  std::array<TriangleId, linear::kBlockLanes> slots{};
  std::array<PatchSurface, linear::kBlockLanes> surfaces;
  std::size_t count = 0;
  const auto fit = [&] {
    lanes.fit(count);
    for (std::size_t l = 0; l < count; ++l) {
      const auto slot = static_cast<std::size_t>(slots[l]);
      if (patched_.contains(slots[l])) patches_[slot].stiffness = lanes.stiffness_of(l);
      if (surfaces[l].is_bent) rest_[slot] = make_rest_bending(surfaces[l].at, lanes.fit_of(l));
      if (sheet.mesh.is_curved()) continue;
      std::array<BendingSide, 3>& sides = sides_[static_cast<std::size_t>(fitted_.place(slots[l]))];
      for (std::size_t k = 0; k < 3; ++k) sides[k] = lanes.side_of(l, k);
    }
    count = 0;
  };
  for (const TriangleId slot : fitted_.members()) {
    interruption_point();
    const MaterialLaw& law = sheet.elements.law(slot);
    if (!sheet.elements.has_material(slot) || !law.has_bending()) continue;
    const PatchGeometry patch =
        sheet.mesh.is_curved() ? curved_patch(sheet, slot, surfaces[count]) : flat_patch(sheet, clamps_, slot);
    lanes.set(count, patch, law.bending, law.inverse_bending);
    slots[count++] = slot;
    if (count == linear::kBlockLanes) fit();
  }
  if (count > 0) fit();
}

void BendingOperator::mark_rows(std::span<const VertexId> vertices) {
  for (const VertexId v : vertices) {
    if (v != mesh::kNone && v < rows_.num_rows()) changed_rows_.insert(v);
  }
}

void BendingOperator::make_edges(const RestSheet& sheet) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
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
    const std::span<const BendingEdge> before = edges_.row(slot);
    edge_row_.clear();
    for (int k = 0; k < 3; ++k) {
      const auto old =
          std::find_if(before.begin(), before.end(), [&](const auto& edge) { return edge.first_edge == k; });
      const TriangleId other = sheet.elements.has_material(slot) ? mesh.neighbour(slot, k) : mesh::kNone;
      const bool is_kept = other != mesh::kNone && !patched_.contains(slot) && !patched_.contains(other);
      if (!is_kept && old != before.end()) mark_rows(old->vertex);
      if (is_kept && old != before.end()) edge_row_.push_back(*old);
      if (is_kept || other < slot) continue;
      BendingEdge edge;
      if (!make_edge(sheet, slot, other, k, edge)) continue;
      edge_row_.push_back(edge);
      mark_rows(edge.vertex);
    }
    if (!before.empty() || !edge_row_.empty()) edges_.set_row(slot, edge_row_);
  }
}

bool BendingOperator::make_edge(const RestSheet& sheet, TriangleId slot, TriangleId other, int k, BendingEdge& edge) {
  const RestElements& elements = sheet.elements;
  if (!elements.law(slot).has_bending() || !elements.law(other).has_bending())
    return false;  // no moment crosses the edge
  const auto first = static_cast<std::size_t>(k);
  const std::size_t second = corner_across(sheet.mesh, other, slot);
  const std::array<std::size_t, 6> places = places_of_second(first, second);
  edge.first_edge = k;
  edge.material = {material_at(sheet, slot), material_at(sheet, other)};
  const std::array<VertexId, 6>& mine = patches_[static_cast<std::size_t>(slot)].vertex;
  const std::array<VertexId, 6>& theirs = patches_[static_cast<std::size_t>(other)].vertex;
  std::copy(mine.begin(), mine.end(), edge.vertex.begin());
  for (std::size_t i = 0; i < 6; ++i) edge.vertex[places[i]] = theirs[i];
  const auto side = [&](TriangleId at, std::size_t opposite) -> const BendingSide& {
    return sides_[static_cast<std::size_t>(fitted_.place(at))][opposite];
  };
  return join_sides(side(slot, first), side(other, second), places, edge);
}

void BendingOperator::add_forces(std::span<const ElementBlock> blocks, const linear::VertexField& x,
                                 linear::VertexField& f) const {
  if (angles_ != nullptr) return angles_->add_forces(x, f);
  add_bending_forces(rows_, x, f);
  add_clamp_forces(clamp_forces_, f);
  add_rest_bending_forces(rest(blocks), x, x, {}, f);
}

void BendingOperator::add_forces(std::span<const ElementBlock> blocks, const linear::VertexField& x,
                                 const linear::VertexField& v, std::span<const double> beta,
                                 linear::VertexField& damped, linear::VertexField& f) const {
  if (patches_.empty()) return;
  if (angles_ != nullptr) {
    add_bending_damping(terms(blocks), beta, v, f);
    angles_->add_forces(x, f);
    return;
  }
  if (is_uniform(beta)) {
    damped = x + damping_of(beta, 0) * v;
    add_bending_forces(rows_, damped, f);
  } else {
    add_bending_forces(rows_, x, f);
    add_bending_damping(terms(blocks), beta, v, f);
  }
  add_clamp_forces(clamp_forces_, f);
  add_rest_bending_forces(rest(blocks), x, v, beta, f);
}

double BendingOperator::energy(std::span<const ElementBlock> blocks, const linear::VertexField& x) const {
  if (angles_ != nullptr) return angles_->energy(x);
  return bending_energy(rows_, x) + clamp_energy(clamp_forces_, x) + rest_bending_energy(rest(blocks), x);
}

void BendingOperator::add_to(StateHash& hash) const {
  for (const BendingPatch& patch : patches_) {
    hash.add_span(std::span<const VertexId>(patch.vertex));
    hash.add_span(std::span<const double>(patch.stiffness));
  }
  for (int slot = 0; slot < edges_.num_rows(); ++slot) {
    for (const BendingEdge& edge : edges_.row(slot)) {
      hash.add_span(std::span<const VertexId>(edge.vertex));
      hash.add_span(std::span<const double>(edge.kink));
      hash.add_span(std::span<const double>(edge.load));
    }
  }
  for (const RestBending& rest : rest_) {
    for (const Eigen::Vector3d& load : rest.load) hash.add_span(std::span<const double>(load.data(), 3));
    hash.add_span(std::span<const double>(rest.inertia.data(), 9));
    hash.add(rest.energy);
    hash.add_span(std::span<const double>(rest.excess));
  }
  for (int i = 0; i < rows_.num_rows(); ++i) {
    const std::span<const BendingEntry> row = rows_.row(i);
    hash.add(static_cast<std::uint64_t>(row.size()));
    for (const BendingEntry& entry : row) {
      hash.add(entry.value);
      hash.add(entry.column);
    }
  }
}

}  // namespace kerf::fem
