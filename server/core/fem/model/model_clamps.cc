// The part of Model that holds slopes at the border, or loads them with moments.
#include <algorithm>
#include <array>

#include "server/base/check.h"
#include "server/base/sort_unique.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

}  // namespace

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
  sort_unique(slots);
  rows_.clear();
  make_patches(mesh, slots);
  stiffness_bound_.update(stiffness_problem(mesh), {}, {}, rows_.members());
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
  sort_unique(slots);
  std::vector<TriangleId> owners = slots;
  for (const TriangleId slot : slots) {
    const BendingPatch& patch = patches_[static_cast<std::size_t>(slot)];
    std::array<Eigen::Vector3d, 6> held;
    held.fill(Eigen::Vector3d::Zero());
    const std::array<Eigen::Vector3d, 3> slopes = held_slopes(mesh, slot);
    std::copy(slopes.begin(), slopes.end(), held.begin() + 3);
    add_clamp_forces_of(patch.vertex, held, [&](std::size_t i, std::size_t j) {
      return patch.at(static_cast<int>(i), static_cast<int>(j));
    });
    for (const TriangleId other : mesh.record(slot).neighbours) {
      if (other != mesh::kNone && other < slot) owners.push_back(other);
    }
  }
  sort_unique(owners);
  for (const TriangleId slot : owners) {
    for (const BendingEdge& edge : bending_edges_.row(slot)) {
      const TriangleId other = mesh.neighbour(slot, edge.first_edge);
      const auto first = static_cast<std::size_t>(edge.first_edge);
      const std::array<std::size_t, 6> places = places_of_second(first, corner_across(mesh, other, slot));
      std::array<Eigen::Vector3d, 8> held;
      held.fill(Eigen::Vector3d::Zero());
      const std::array<Eigen::Vector3d, 3> mine = held_slopes(mesh, slot);
      const std::array<Eigen::Vector3d, 3> theirs = held_slopes(mesh, other);
      for (std::size_t k = 0; k < 3; ++k) {
        held[3 + k] += mine[k];
        held[places[3 + k]] += theirs[k];  // zero at the shared edge itself, which has no clamp
      }
      add_clamp_forces_of(edge.vertex, held, [&](std::size_t i, std::size_t j) { return edge.at(i, j); });
    }
  }
}

std::array<Eigen::Vector3d, 3> Model::held_slopes(const mesh::TriangleMesh& mesh, TriangleId slot) const {
  std::array<Eigen::Vector3d, 3> held;
  held.fill(Eigen::Vector3d::Zero());
  const std::array<VertexId, 3> vertices = corners(slot);
  std::array<Eigen::Vector2d, 3> X;
  for (std::size_t k = 0; k < 3; ++k) X[k] = mesh.rest_position(vertices[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    Eigen::Matrix<double, 3, 2> gradient;
    if (find_clamped_edge(mesh, slot, k, gradient)) held[k] = gradient * clamp_arm(X, k);
  }
  return held;
}

template <typename Entry>
void Model::add_clamp_forces_of(std::span<const VertexId> vertices, std::span<const Eigen::Vector3d> held,
                                const Entry& entry) {
  for (std::size_t a = 0; a < vertices.size(); ++a) {
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (std::size_t b = 3; b < vertices.size(); ++b) pull -= entry(a, b) * held[b];
    if (vertices[a] == mesh::kNone) {
      clamp_forces_.energy -= 0.5 * pull.dot(held[a]);
    } else if (!pull.isZero(0.0)) {
      clamp_forces_.forces.push_back({vertices[a], pull});
    }
  }
}

EdgeMoment Model::edge_moment(const mesh::TriangleMesh& mesh, TriangleId slot, int edge,
                              double moment_per_length) const {
  KERF_CHECK(has_material(slot) && mesh.neighbour(slot, edge) == mesh::kNone, "a border edge of a solid triangle");
  const auto k = static_cast<std::size_t>(edge);
  const MaterialLaw& own = law(slot);
  const Eigen::Matrix2d sides = own.axes * mesh.rest_edges(slot);
  PatchGeometry patch{{Eigen::Vector2d::Zero(), sides.col(0), sides.col(1)}, {}, {}};
  const std::array<Eigen::Vector2d, 3>& X = patch.corners;
  const bool is_flat = own.has_bending() && !mesh.is_curved();
  EdgeMoment made;
  made.edge = k;
  made.arm = clamp_arm(X, k).norm();
  made.moment = moment_per_length * (X[(k + 2) % 3] - X[(k + 1) % 3]).norm();
  const std::array<VertexId, 3> vertices = corners(slot);
  for (std::size_t i = 0; i < 3; ++i) {
    made.vertex[i] = vertices[i];
    patch.opposite[i].setZero();
    const TriangleId across = mesh.neighbour(slot, static_cast<int>(i));
    if (!is_flat || across == mesh::kNone) continue;
    made.vertex[3 + i] = mesh.vertices(across)[corner_across(mesh, across, slot)];
    patch.opposite[i] = own.axes * (mesh.rest_position(made.vertex[3 + i]) - mesh.rest_position(vertices[0]));
    patch.edges[i] = PatchEdge::kNeighbour;
  }
  Eigen::Matrix<double, 3, 2> held;
  if (find_clamped_edge(mesh, slot, k, held)) return made;
  patch.edges[k] = PatchEdge::kClamped;
  const BendingFit fit = fit_bending(patch, own.has_bending() ? own.inverse_bending : Eigen::Matrix3d::Identity());
  // Among the conditions w = W x, the one of the edge contains the slope, arm x_nu - L x. It takes the value that
  // minimises the energy w.law w / 2 with the others fixed.
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
