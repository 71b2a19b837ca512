#include "server/core/fem/model/border_clamps.h"

#include <algorithm>

#include "server/base/check.h"
#include "server/base/sort_unique.h"
#include "server/core/fem/model/patch_geometry.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

// Adds the forces and the energy of held slopes. entry(a, b) is the entry of Q at places a and b. held[a] is the slope
// at place a, whose vertex is then kNone, and 0 at other places.
template <typename Entry>
void add_forces_of(std::span<const VertexId> vertices, std::span<const Eigen::Vector3d> held, const Entry& entry,
                   ClampForces& made) {
  for (std::size_t a = 0; a < vertices.size(); ++a) {
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (std::size_t b = 3; b < vertices.size(); ++b) pull -= entry(a, b) * held[b];
    if (vertices[a] == mesh::kNone) {
      made.energy -= 0.5 * pull.dot(held[a]);
    } else if (!pull.isZero(0.0)) {
      made.forces.push_back({vertices[a], pull});
    }
  }
}

}  // namespace

std::optional<Eigen::Matrix<double, 3, 2>> BorderClamps::gradient_at(const RestSheet& sheet, TriangleId slot,
                                                                     std::size_t k) const {
  if (clamps_.empty() || sheet.mesh.neighbour(slot, static_cast<int>(k)) != mesh::kNone) return std::nullopt;
  const std::array<VertexId, 3> vertices = sheet.elements.corners(slot);
  const Clamp* const a = find(vertices[(k + 1) % 3]);
  const Clamp* const b = find(vertices[(k + 2) % 3]);
  if (a == nullptr || b == nullptr) return std::nullopt;
  return 0.5 * (a->gradient + b->gradient);
}

std::array<Eigen::Vector3d, 3> BorderClamps::held_slopes(const RestSheet& sheet, TriangleId slot) const {
  std::array<Eigen::Vector3d, 3> held;
  held.fill(Eigen::Vector3d::Zero());
  const std::array<VertexId, 3> vertices = sheet.elements.corners(slot);
  std::array<Eigen::Vector2d, 3> X;
  for (std::size_t k = 0; k < 3; ++k) X[k] = sheet.mesh.rest_position(vertices[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto gradient = gradient_at(sheet, slot, k);
    if (gradient) held[k] = *gradient * clamp_arm(X, k);
  }
  return held;
}

void BorderClamps::add_slots(const RestElements& elements, std::vector<TriangleId>& slots) const {
  for (const Clamp& clamp : clamps_) {
    if (clamp.vertex >= elements.num_vertices()) continue;
    const std::span<const TriangleId> around = elements.incident_slots().row(clamp.vertex);
    slots.insert(slots.end(), around.begin(), around.end());
  }
}

const Clamp* BorderClamps::find(VertexId vertex) const {
  const auto at = std::lower_bound(clamps_.begin(), clamps_.end(), vertex,
                                   [](const Clamp& clamp, VertexId v) { return clamp.vertex < v; });
  return at != clamps_.end() && at->vertex == vertex ? &*at : nullptr;
}

ClampForces make_clamp_forces(const RestSheet& sheet, const BorderClamps& clamps, std::span<const BendingPatch> patches,
                              const linear::RowStore<BendingEdge>& edges) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
  ClampForces made;
  std::vector<TriangleId> slots;
  clamps.add_slots(sheet.elements, slots);
  sort_unique(slots);
  std::vector<TriangleId> owners = slots;
  for (const TriangleId slot : slots) {
    const BendingPatch& patch = patches[static_cast<std::size_t>(slot)];
    std::array<Eigen::Vector3d, 6> held;
    held.fill(Eigen::Vector3d::Zero());
    const std::array<Eigen::Vector3d, 3> slopes = clamps.held_slopes(sheet, slot);
    std::copy(slopes.begin(), slopes.end(), held.begin() + 3);
    const auto entry = [&](std::size_t i, std::size_t j) { return patch.at(static_cast<int>(i), static_cast<int>(j)); };
    add_forces_of(patch.vertex, held, entry, made);
    for (const TriangleId other : mesh.record(slot).neighbours) {
      if (other != mesh::kNone && other < slot) owners.push_back(other);
    }
  }
  sort_unique(owners);
  for (const TriangleId slot : owners) {
    for (const BendingEdge& edge : edges.row(slot)) {
      const TriangleId other = mesh.neighbour(slot, edge.first_edge);
      const auto first = static_cast<std::size_t>(edge.first_edge);
      const std::array<std::size_t, 6> places = places_of_second(first, corner_across(mesh, other, slot));
      std::array<Eigen::Vector3d, 8> held;
      held.fill(Eigen::Vector3d::Zero());
      const std::array<Eigen::Vector3d, 3> mine = clamps.held_slopes(sheet, slot);
      const std::array<Eigen::Vector3d, 3> theirs = clamps.held_slopes(sheet, other);
      for (std::size_t k = 0; k < 3; ++k) {
        held[3 + k] += mine[k];
        held[places[3 + k]] += theirs[k];  // zero at the shared edge itself, which has no clamp
      }
      add_forces_of(
          edge.vertex, held, [&](std::size_t i, std::size_t j) { return edge.at(i, j); }, made);
    }
  }
  return made;
}

EdgeMoment make_edge_moment(const RestSheet& sheet, const BorderClamps& clamps, TriangleId slot, int edge,
                            double moment_per_length) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
  KERF_CHECK(sheet.elements.has_material(slot) && mesh.neighbour(slot, edge) == mesh::kNone,
             "a border edge of a solid triangle");
  const auto k = static_cast<std::size_t>(edge);
  const MaterialLaw& own = sheet.elements.law(slot);
  const Eigen::Matrix2d sides = own.axes * mesh.rest_edges(slot);
  PatchGeometry patch{{Eigen::Vector2d::Zero(), sides.col(0), sides.col(1)}, {}, {}};
  const std::array<Eigen::Vector2d, 3>& X = patch.corners;
  const bool is_flat = own.has_bending() && !mesh.is_curved();
  EdgeMoment made;
  made.edge = k;
  made.arm = clamp_arm(X, k).norm();
  made.moment = moment_per_length * (X[(k + 2) % 3] - X[(k + 1) % 3]).norm();
  const std::array<VertexId, 3> vertices = sheet.elements.corners(slot);
  for (std::size_t i = 0; i < 3; ++i) {
    made.vertex[i] = vertices[i];
    patch.opposite[i].setZero();
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(i));
    if (!is_flat || across == mesh::kNone) continue;
    made.vertex[3 + i] = mesh.vertices(across)[corner_across(mesh, across, slot)];
    patch.opposite[i] = own.axes * (mesh.rest_position(made.vertex[3 + i]) - mesh.rest_position(vertices[0]));
    patch.edges[i] = PatchEdge::kNeighbour;
  }
  if (clamps.gradient_at(sheet, slot, k)) return made;
  patch.edges[k] = PatchEdge::kClamped;
  const BendingFit fit = fit_bending(patch, own.has_bending() ? own.inverse_bending : Eigen::Matrix3d::Identity());
  // Among the conditions w = W x, the one of the edge contains the slope, arm x_nu - L x. The slope takes the value
  // that minimises the energy w.law w / 2 with the other conditions fixed.
  const auto row = static_cast<Eigen::Index>(k);
  constexpr double kLeastLaw = 1e-3;  // -; below it the other conditions leave the slope undetermined
  const bool is_coupled = fit.law(row, row) > kLeastLaw * fit.law.trace();
  if (is_coupled && is_flat) made.compliance = 1.0 / (fit.law(row, row) * made.arm * made.arm);
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

}  // namespace kerf::fem
