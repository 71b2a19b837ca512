#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/intersections.h"
#include "server/core/mesh/ids.h"
#include "server/core/scene/sheet_config.h"
#include "server/core/sheet/sheet.h"

namespace kerf::analysis {

using Components = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5, 1>;  // the components of a quantity, at most 5

// Measures quantities that belong to a sheet as a whole. It keeps its memory from one measurement to the next.
class WholeSheet {
 public:
  // Returns the components of `quantity`, in their order and units, of the sheet as it is. `quantity` must be one that
  // takes no place: energy, momentum, angular momentum, centre of mass, extent or intersections.
  Components measure(const sheet::Sheet& sheet, scene::Quantity quantity);

 private:
  [[nodiscard]] std::int64_t count_intersections(const sheet::Sheet& sheet);

  std::vector<std::array<mesh::VertexId, 3>> triangles_;  // the solid ones
  contact::IntersectionSearch intersections_;
};

}  // namespace kerf::analysis
