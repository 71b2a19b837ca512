#include "server/core/sheet/vertex_strains.h"

#include <cmath>

#include "server/core/fem/statics/recovered_fields.h"

namespace kerf::sheet {

std::vector<float> dominant_strains(const fem::Model& model, const linear::VertexField& x) {
  const std::vector<Eigen::Vector3d> of_slots =
      fem::triangle_field(model, x, fem::MembraneField::kBiotStrain, fem::FieldAxes::kRest);
  const std::vector<Eigen::Vector3d> of_vertices = fem::vertex_field(model, of_slots, fem::Recovery::kMean);
  std::vector<float> dominant;
  dominant.reserve(of_vertices.size());
  for (const Eigen::Vector3d& strain : of_vertices) {
    // `strain` is (e11, e22, 2 e12).
    const double mean = 0.5 * (strain[0] + strain[1]);
    const double radius = std::hypot(0.5 * (strain[0] - strain[1]), 0.5 * strain[2]);
    dominant.push_back(static_cast<float>(mean < 0.0 ? mean - radius : mean + radius));
  }
  return dominant;
}

}  // namespace kerf::sheet
