#include "server/core/fem/statics/recovered_fields.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

#include "server/base/check.h"
#include "server/core/fem/element/element_lanes.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Matrix2d symmetric(double a11, double a22, double a12) {
  return Matrix2d{
      {a11, a12},
      {a12, a22},
  };
}

// Returns the field of a triangle as a tensor in material axes.
Matrix2d tensor_in_lane(const LaneFrames& frames, std::size_t lane, const MaterialLaw& law, MembraneLaw membrane_law,
                        MembraneField field) {
  const Matrix2d S = symmetric(frames.S11[lane], frames.S22[lane], frames.S12[lane]);
  if (field == MembraneField::kBiotStrain) return S - Matrix2d::Identity();
  const double det = S.determinant();
  if (membrane_law == MembraneLaw::kGreen) {
    const Matrix2d E = 0.5 * (S * S - Matrix2d::Identity());
    const Vector3d sigma = law.membrane * Vector3d(E(0, 0), E(1, 1), 2.0 * E(0, 1)) / law.material.thickness;
    const Matrix2d US = S * symmetric(sigma[0], sigma[1], sigma[2]);  // R^T P
    if (field == MembraneField::kBiotStress) return 0.5 * (US + US.transpose());
    return det > 0.0 ? Matrix2d(US * S / det) : Matrix2d::Zero();
  }
  const Vector3d e(S(0, 0) - 1.0, S(1, 1) - 1.0, 2.0 * S(0, 1));
  const Vector3d sigma = law.membrane * e / law.material.thickness;
  if (field == MembraneField::kBiotStress) return symmetric(sigma[0], sigma[1], sigma[2]);
  // T = R^T P has the skew part a, as in membrane.h. It makes T S / det, the Cauchy stress turned by R, symmetric.
  const double a = (S(0, 1) * (sigma[0] - sigma[1]) + sigma[2] * (S(1, 1) - S(0, 0))) * frames.inverse_trace[lane];
  const Matrix2d T{
      {sigma[0], sigma[2] - a},
      {sigma[2] + a, sigma[1]},
  };
  return det > 0.0 ? Matrix2d(T * S / det) : Matrix2d::Zero();
}

// Returns the corners of a slot relative to that at `vertex`: m, rest axes.
std::array<Vector2d, 3> corners_from(const Model& model, const ElementBlock& block, std::size_t lane,
                                     mesh::VertexId vertex) {
  const Matrix2d Dm_inv{
      {block.g1[0][lane], block.g1[1][lane]},
      {block.g2[0][lane], block.g2[1][lane]},
  };
  const Matrix2d Dm = model.materials().of(block, lane).axes.transpose() * Dm_inv.inverse();
  const std::array<Vector2d, 3> from_first{Vector2d::Zero(), Dm.col(0), Dm.col(1)};
  std::array<Vector2d, 3> from = from_first;
  for (std::size_t k = 1; k < 3; ++k) {
    if (block.vertex[k][lane] != vertex) continue;
    for (std::size_t i = 0; i < 3; ++i) from[i] = from_first[i] - from_first[k];
  }
  return from;
}

// Calls visit(slot, block, lane) for the triangles around a vertex.
template <typename Visit>
void for_around(const Model& model, mesh::VertexId vertex, const Visit& visit) {
  for (const mesh::TriangleId slot : model.elements().incident_slots().row(vertex)) {
    visit(static_cast<std::size_t>(slot), model.element_blocks()[static_cast<std::size_t>(slot / kLanes)],
          static_cast<std::size_t>(slot % kLanes));
  }
}

// Returns true if triangles of one material surround the vertex: each neighbour is then in two of them.
bool is_inside(const Model& model, mesh::VertexId vertex) {
  std::vector<mesh::VertexId> others;
  bool has_one_material = true;
  const std::span<const mesh::TriangleId> around = model.elements().incident_slots().row(vertex);
  for_around(model, vertex, [&](std::size_t slot, const ElementBlock& block, std::size_t lane) {
    has_one_material = has_one_material &&
                       &model.elements().law(static_cast<mesh::TriangleId>(slot)) == &model.elements().law(around[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      if (block.vertex[k][lane] != vertex) others.push_back(block.vertex[k][lane]);
    }
  });
  std::sort(others.begin(), others.end());
  for (std::size_t i = 0; i + 1 < others.size(); i += 2) {
    if (others[i] != others[i + 1] || (i + 2 < others.size() && others[i + 1] == others[i + 2])) return false;
  }
  return has_one_material && !others.empty();
}

// The linear fit to values at the centroids around a vertex, weighted with areas.
struct Plane {
  Vector3d at_vertex = Vector3d::Zero();
  Eigen::Matrix<double, 3, 2> slope = Eigen::Matrix<double, 3, 2>::Zero();  // 1/m

  Plane(const Model& model, mesh::VertexId vertex, std::span<const Vector3d> of_slots) {
    double area = 0.0;
    Vector3d mean = Vector3d::Zero();
    Vector2d middle = Vector2d::Zero();
    Matrix2d spread = Matrix2d::Zero();
    for_around(model, vertex, [&](std::size_t slot, const ElementBlock& block, std::size_t lane) {
      const std::array<Vector2d, 3> corners = corners_from(model, block, lane, vertex);
      const Vector2d at = (corners[0] + corners[1] + corners[2]) / 3.0;
      const double weight = block.area[lane];
      area += weight;
      mean += weight * of_slots[slot];
      middle += weight * at;
      spread += weight * at * at.transpose();
      slope += weight * of_slots[slot] * at.transpose();
    });
    mean /= area;
    middle /= area;
    slope = (slope / area - mean * middle.transpose()) * (spread / area - middle * middle.transpose()).inverse();
    at_vertex = mean - slope * middle;
  }
};

Vector3d mean_around(const Model& model, mesh::VertexId vertex, std::span<const Vector3d> of_slots) {
  double area = 0.0;
  Vector3d sum = Vector3d::Zero();
  for_around(model, vertex, [&](std::size_t slot, const ElementBlock& block, std::size_t lane) {
    area += block.area[lane];
    sum += block.area[lane] * of_slots[slot];
  });
  return area > 0.0 ? Vector3d(sum / area) : sum;
}

// Calls visit(vertex, offset from `vertex`) for the corners of the triangles around a vertex.
template <typename Visit>
void for_corners(const Model& model, mesh::VertexId vertex, const Visit& visit) {
  for_around(model, vertex, [&](std::size_t /*slot*/, const ElementBlock& block, std::size_t lane) {
    const std::array<Vector2d, 3> corners = corners_from(model, block, lane, vertex);
    for (std::size_t k = 0; k < 3; ++k) {
      if (block.vertex[k][lane] != vertex) visit(block.vertex[k][lane], corners[k]);
    }
  });
}

// Calls visit(vertex, offset from `vertex`) for the corners that lie across the edges opposite `vertex` in the
// triangles around it.
template <typename Visit>
void for_corners_across(const Model& model, mesh::VertexId vertex, const Visit& visit) {
  for_around(model, vertex, [&](std::size_t slot, const ElementBlock& block, std::size_t lane) {
    const std::array<Vector2d, 3> corners = corners_from(model, block, lane, vertex);
    std::size_t k = 0;
    while (block.vertex[k][lane] != vertex) ++k;
    const mesh::VertexId a = block.vertex[(k + 1) % 3][lane];
    const mesh::VertexId b = block.vertex[(k + 2) % 3][lane];
    for_around(model, a, [&](std::size_t other_slot, const ElementBlock& other, std::size_t l) {
      if (other_slot == slot) return;
      const std::array<mesh::VertexId, 3> at{other.vertex[0][l], other.vertex[1][l], other.vertex[2][l]};
      if (std::find(at.begin(), at.end(), b) == at.end()) return;
      const std::array<Vector2d, 3> from = corners_from(model, other, l, a);
      for (std::size_t i = 0; i < 3; ++i) {
        if (at[i] != a && at[i] != b) visit(at[i], Vector2d(corners[(k + 1) % 3] + from[i]));
      }
    });
  });
}

Vector3d recover_by_patches(const Model& model, mesh::VertexId vertex, std::span<const Vector3d> of_slots,
                            const std::vector<bool>& inside) {
  if (inside[static_cast<std::size_t>(vertex)]) return Plane(model, vertex, of_slots).at_vertex;
  int count = 0;
  Vector3d sum = Vector3d::Zero();
  const auto extrapolate = [&](mesh::VertexId other, const Vector2d& at) {
    if (!inside[static_cast<std::size_t>(other)]) return;
    const Plane plane(model, other, of_slots);
    sum += plane.at_vertex - plane.slope * at;
    ++count;
  };
  for_corners(model, vertex, extrapolate);
  if (count == 0) for_corners_across(model, vertex, extrapolate);
  return count > 0 ? Vector3d(sum / count) : mean_around(model, vertex, of_slots);
}

}  // namespace

std::vector<Vector3d> triangle_field(const Model& model, const linear::VertexField& x, MembraneField field,
                                     FieldAxes axes) {
  const double shear = field == MembraneField::kBiotStrain ? 2.0 : 1.0;
  std::vector<Vector3d> values(static_cast<std::size_t>(model.num_slots()), Vector3d::Zero());
  LaneFrames frames;
  for (std::size_t slot = 0; slot < values.size(); ++slot) {
    const ElementBlock& block = model.element_blocks()[slot / kLanes];
    const std::size_t lane = slot % kLanes;
    if (lane == 0) frames_at(block, x, frames);
    if (block.area[lane] == 0.0) continue;
    const MaterialLaw& law = model.materials().of(block, lane);
    Matrix2d tensor = tensor_in_lane(frames, lane, law, model.materials().membrane_law(), field);
    if (axes == FieldAxes::kRest) tensor = law.axes.transpose() * tensor * law.axes;
    values[slot] = {tensor(0, 0), tensor(1, 1), shear * 0.5 * (tensor(0, 1) + tensor(1, 0))};
  }
  return values;
}

std::vector<Vector3d> vertex_field(const Model& model, std::span<const Vector3d> of_slots, Recovery recovery) {
  KERF_CHECK(of_slots.size() == static_cast<std::size_t>(model.num_slots()), "one value a slot");
  std::vector<Vector3d> values(static_cast<std::size_t>(model.num_vertices()));
  std::vector<bool> inside(values.size(), false);
  for (int v = 0; recovery == Recovery::kPatch && v < model.num_vertices(); ++v) {
    inside[static_cast<std::size_t>(v)] = is_inside(model, v);
  }
  for (int v = 0; v < model.num_vertices(); ++v) {
    values[static_cast<std::size_t>(v)] =
        recovery == Recovery::kPatch ? recover_by_patches(model, v, of_slots, inside) : mean_around(model, v, of_slots);
  }
  return values;
}

}  // namespace kerf::fem
