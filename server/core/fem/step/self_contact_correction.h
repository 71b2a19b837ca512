#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/model/model.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

class ContactConstraint;

// Contact of the sheet with itself after an implicit substep, whose equations do not know of it (Bridson, Fedkiw,
// Anderson 2002). Vertices move on straight lines from the start of the substep to its end, with contact as between
// explicit substeps. What contact changes on the way then changes the end. Velocities of a scheme of second order are
// not the mean ones of the way, so ContactConstraint::end_self_contact() must follow.
class SelfContactCorrection {
 public:
  // Corrects the positions `x` (m) at the end of a substep of `h` (s) that began at `start` (m). Returns true if
  // contact changed anything; what it does not change keeps its bits. Allocates memory after each change of the mesh.
  bool correct(const Model& model, const Loads& loads, double h, const linear::VertexField& start,
               ContactConstraint& contact, linear::VertexField& x);
  // Change of velocities by the last correct() that returned true, m/s, by vertex.
  [[nodiscard]] linear::VertexField& change() { return way_; }

 private:
  void resize(Eigen::Index num_vertices);
  void collect(std::span<const mesh::VertexId> moved);

  State motion_;
  linear::VertexField way_;  // m/s, velocities without contact; at the end their change
  std::vector<double> inverse_mass_;
  LocalInertia none_;
  std::vector<mesh::VertexId> moved_;
  std::vector<std::uint8_t> is_moved_;  // by vertex
};

}  // namespace kerf::fem
