#include "server/core/sheet/initial_state.h"

#include <numeric>
#include <string>
#include <utility>

#include "server/core/fem/model/model.h"
#include "server/core/scene/integrator_settings.h"
#include "server/core/scene/region.h"
#include "server/core/sheet/lip_parting.h"

namespace kerf::sheet {

namespace {

Eigen::Matrix3Xd initial_velocities(const scene::SheetConfig& config, const scene::BuiltMesh& built,
                                    const std::vector<fem::Material>& materials) {
  const Eigen::Matrix3Xd& x = built.positions;
  Eigen::Matrix3Xd v = Eigen::Matrix3Xd::Zero(3, x.cols());
  if (!config.initial_velocity) return v;
  const scene::InitialVelocity& given = *config.initial_velocity;
  const Eigen::Vector3d centre =
      given.centre ? *given.centre : fem::Model(built.mesh, materials).centre_of_mass(linear::VertexField(x));
  for (Eigen::Index i = 0; i < x.cols(); ++i) v.col(i) = given.linear + given.angular.cross(x.col(i) - centre);
  return v;
}

}  // namespace

Result<InitialState> make_initial_state(scene::SheetConfig config) {
  KERF_TRY(validate(config));
  KERF_TRY_ASSIGN(scene::BuiltMesh built, scene::build_mesh(config));
  if (built.mesh.num_vertices() > config.max_vertices) {
    return resource_exhausted("TOO_MANY_VERTICES", "the sheet has " + std::to_string(built.mesh.num_vertices()) +
                                                       " vertices; its limit is " +
                                                       std::to_string(config.max_vertices));
  }
  KERF_TRY(scene::check_vertex_limit(config.integrator, built.mesh.num_vertices()));
  KERF_TRY_ASSIGN(std::vector<mesh::VertexId> pinned,
                  scene::find_pins(built.mesh, built.components, config.pins, "pins"));
  KERF_TRY_ASSIGN(scene::SheetMaterials assigned, scene::assign_materials(config, built));
  auto shared = std::make_shared<const scene::SheetConfig>(std::move(config));
  KERF_TRY_ASSIGN(scene::HeldVertices held, scene::HeldVertices::create(shared, built));
  KERF_TRY_ASSIGN(scene::AppliedForces applied, scene::AppliedForces::create(shared, built));
  Eigen::Matrix3Xd velocities = initial_velocities(*shared, built, assigned.by_region);
  const scene::SelfContact& self_contact = shared->self_contact;
  MaterialSetup materials(std::move(assigned), *shared, self_contact.is_on, built.mesh);
  if (self_contact.is_on) {
    std::vector<mesh::TriangleId> triangles(static_cast<std::size_t>(built.mesh.num_triangle_slots()));
    std::iota(triangles.begin(), triangles.end(), 0);
    const double thickness = self_contact.thickness.value_or(2.0 * materials.half_thickness());
    part_lips(built.mesh, triangles, pinned, thickness, built.positions);
  }
  return InitialState{std::move(shared), std::move(built), std::move(materials), std::move(velocities),
                      std::move(pinned), std::move(held),  std::move(applied)};
}

}  // namespace kerf::sheet
