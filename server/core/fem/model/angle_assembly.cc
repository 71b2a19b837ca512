#include "server/core/fem/model/angle_assembly.h"

#include <vector>

#include <Eigen/Core>

#include "server/core/fem/model/patch_geometry.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;

// Returns the height (m) of corner k over the edge opposite it.
double rest_height(const std::array<Eigen::Vector2d, 3>& corners, std::size_t k) {
  return clamp_arm(corners, k).norm();
}

}  // namespace

AngleBending make_angle_bending(const RestSheet& sheet, const BorderClamps& clamps,
                                std::span<const BendingPatch> patches, const linear::RowStore<BendingEdge>& edges,
                                std::span<const std::array<BendingSide, 3>> sides) {
  const mesh::TriangleMesh& mesh = sheet.mesh;
  const RestElements& elements = sheet.elements;
  AngleBending made;
  // For each slot, the fold at each edge and the height of the vertex across it.
  std::vector<std::array<int, 3>> fold_at(static_cast<std::size_t>(elements.num_slots()), {-1, -1, -1});
  std::vector<std::array<double, 3>> reach(fold_at.size(), {0.0, 0.0, 0.0});
  const auto rest_corners = [&](TriangleId slot) {
    std::array<Eigen::Vector2d, 3> at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = mesh.rest_position(elements.corners(slot)[k]);
    return at;
  };
  for (TriangleId slot = 0; slot < elements.num_slots(); ++slot) {
    if (!elements.has_material(slot)) continue;
    const std::array<mesh::VertexId, 3> vertex = elements.corners(slot);
    const std::array<Eigen::Vector2d, 3> X = rest_corners(slot);
    const std::array<Eigen::Vector3d, 3> held = clamps.held_slopes(sheet, slot);
    for (std::size_t k = 0; k < 3; ++k) {
      const TriangleId other = mesh.neighbour(slot, static_cast<int>(k));
      const std::size_t next = (k + 1) % 3;
      const std::size_t last = (k + 2) % 3;
      AngleBending::Fold fold;
      fold.vertex = {vertex[next], vertex[last], vertex[k], mesh::kNone};
      fold.rest.length = (X[last] - X[next]).norm();
      fold.rest.height.fill(rest_height(X, k));
      const auto number = static_cast<int>(made.folds.size());
      if (other != mesh::kNone) {
        if (other < slot) continue;
        const std::size_t corner = corner_across(mesh, other, slot);
        fold.vertex[3] = elements.corners(other)[corner];
        fold.rest.height[1] = rest_height(rest_corners(other), corner);
        fold_at[static_cast<std::size_t>(other)][corner] = number;
        reach[static_cast<std::size_t>(other)][corner] = fold.rest.height[0];
      } else if (clamps.gradient_at(sheet, slot, k)) {
        fold.held = held[k];
      } else {
        continue;
      }
      fold_at[static_cast<std::size_t>(slot)][k] = number;
      reach[static_cast<std::size_t>(slot)][k] = fold.rest.height[1];
      made.folds.push_back(fold);
    }
  }

  for (TriangleId slot = 0; slot < elements.num_slots(); ++slot) {
    if (!elements.has_material(slot) || !elements.law(slot).has_bending()) continue;
    const auto own = static_cast<std::size_t>(slot);
    AngleBending::Patch patch;
    patch.fold = fold_at[own];
    for (int r = 0; r < 3; ++r) {
      for (int s = 0; s < 3; ++s) {
        patch.stiffness(r, s) = patches[own].at(3 + r, 3 + s) * reach[own][static_cast<std::size_t>(r)] *
                                reach[own][static_cast<std::size_t>(s)];
      }
    }
    made.patches.push_back(patch);
    for (const BendingEdge& edge : edges.row(slot)) {
      const TriangleId other = mesh.neighbour(slot, edge.first_edge);
      const auto first = static_cast<std::size_t>(edge.first_edge);
      // As in join_sides(): the slopes of the triangles themselves differ by theta, and their fits add to that.
      AngleBending::Kink joined;
      joined.add(fold_at[own][first], 1.0, 0.0);
      double penalty = 0.0;
      const auto add_side = [&](TriangleId triangle, std::size_t k) {
        const auto at = static_cast<std::size_t>(triangle);
        const BendingSide& side = sides[at][k];
        for (std::size_t r = 0; r < 3; ++r) {
          joined.add(fold_at[at][r], -side.slope[3 + r] * reach[at][r],
                     0.5 * side.length * side.moment[3 + r] * reach[at][r]);
        }
        penalty += side.penalty;
      };
      add_side(slot, first);
      add_side(other, corner_across(mesh, other, slot));
      for (std::size_t i = 0; i < joined.fold.size(); ++i) joined.load[i] += penalty * joined.kink[i];
      made.kinks.push_back(joined);
    }
  }
  return made;
}

}  // namespace kerf::fem
