#include "server/core/analysis/whole_sheet.h"

#include <Eigen/Geometry>

#include "server/base/check.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::analysis {

using scene::Quantity;

namespace {

Components energies_of(const sheet::Sheet& sheet) {
  const sheet::Energies e = sheet.energies();
  Components energies(5);
  energies << e.kinetic, e.membrane, e.bending, e.gravity, e.total();
  return energies;
}

Eigen::Vector3d extent_of(const sheet::Sheet& sheet) {
  const linear::VertexField& x = sheet.state().x;
  Eigen::AlignedBox3d box;
  for (Eigen::Index v = 0; v < x.cols(); ++v) {
    if (sheet.mesh().has_material(static_cast<mesh::VertexId>(v))) box.extend(Eigen::Vector3d(x.col(v)));
  }
  return box.sizes();
}

}  // namespace

Components WholeSheet::measure(const sheet::Sheet& sheet, Quantity quantity) {
  const fem::Model& model = sheet.model();
  const fem::State& state = sheet.state();
  switch (quantity) {
    case Quantity::kEnergy:
      return energies_of(sheet);
    case Quantity::kMomentum:
      return model.momentum(state).linear;
    case Quantity::kCentreOfMass:
      return model.centre_of_mass(state.x);
    case Quantity::kAngularMomentum: {
      const fem::Momentum momentum = model.momentum(state);
      return Eigen::Vector3d(momentum.angular - model.centre_of_mass(state.x).cross(momentum.linear));
    }
    case Quantity::kIntersections:
      return Components::Constant(1, static_cast<double>(count_intersections(sheet)));
    default:
      KERF_DCHECK(quantity == Quantity::kExtent, "the quantity belongs to the whole sheet");
      return extent_of(sheet);
  }
}

std::int64_t WholeSheet::count_intersections(const sheet::Sheet& sheet) {
  const mesh::TriangleMesh& mesh = sheet.mesh();
  triangles_.clear();
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) triangles_.push_back(mesh.vertices(t));
  }
  return intersections_.count(triangles_, sheet.state().x);
}

}  // namespace kerf::analysis
