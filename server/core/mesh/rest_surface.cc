#include "server/core/mesh/rest_surface.h"

#include <cmath>
#include <span>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace kerf::mesh {

Facet Facet::of(const std::array<Eigen::Vector2d, 3>& material, const std::array<Eigen::Vector3d, 3>& surface,
                std::int32_t region) {
  Eigen::Matrix2d from;
  from << material[1] - material[0], material[2] - material[0];
  Eigen::Matrix<double, 3, 2> to;
  to << surface[1] - surface[0], surface[2] - surface[0];
  return {material[0], surface[0], to * from.inverse(), region};
}

Eigen::Matrix2d Facet::stretch() const {
  const double along_x = axes.col(0).norm();
  const double shear = axes.col(0).dot(axes.col(1)) / along_x;
  return Eigen::Matrix2d{
      {along_x, shear},
      {0.0, area_ratio() / along_x},
  };
}

double Facet::area_ratio() const {
  return axes.col(0).cross(axes.col(1)).norm();
}

void RestSurface::add_to(StateHash& hash) const {
  for (const Facet& facet : facets) {
    hash.add_span(std::span<const double>(facet.anchor.data(), 2));
    hash.add_span(std::span<const double>(facet.origin.data(), 3));
    hash.add_span(std::span<const double>(facet.axes.data(), 6));
    hash.add(facet.region);
  }
}

}  // namespace kerf::mesh
