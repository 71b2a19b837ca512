#pragma once

#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/base/state_hash.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/command.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/vertex_ancestry.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// The grabs of a sheet, in the order in which they were made; it follows cuts. A grab of a vertex stays at this vertex
// while it has material. Other grabs hold a material point, whichever vertices are around it.
class GrabSet {
 public:
  // Adds a grab. `x`: positions, 3 x V, m. `model`: of the mesh. `dt`: length of a tick, s. Errors: kAlreadyExists
  // GRAB_EXISTS; kResourceExhausted TOO_MANY_GRABS; kInvalidArgument UNKNOWN_VERTEX, POINT_OUTSIDE.
  Status add(const scene::Grab& grab, const mesh::TriangleMesh& mesh, const fem::Model& model,
             const linear::VertexField& x, double dt);
  // Move or end a grab. Error: kNotFound GRAB_NOT_FOUND.
  Status drag(const scene::Drag& drag);
  Status release(const scene::Release& release);
  void clear() { grabs_.clear(); }

  // Computes the stiffness of grabs without a given stiffness again, after a change of material.
  void follow_material(const mesh::TriangleMesh& mesh, const fem::Model& model, double dt);
  // Moves grabs from vertices that an undo removes to the ancestors of these, or else to the material point. Must be
  // called before the mesh is reverted.
  void leave_new_vertices(const VertexAncestry& ancestry, const mesh::TriangleMesh& mesh);
  // Finds the held material points in a mesh that was edited. A point that lost its material moves to the nearest
  // material.
  void follow(const mesh::TriangleMesh& mesh);

  // Overwrites `loads` with the springs for a step of dt (s), in which targets move from GrabState::previous_target to
  // target.
  void set(const fem::Integrator& integrator, const fem::Model& model, double dt, std::vector<fem::Grab>& loads) const;
  // Call after a step: the next one starts from the present targets.
  void end_step();

  // Inserts vertices held by grabs of vertices into `vertices`, which stays sorted.
  void add_vertices_to(std::vector<mesh::VertexId>& vertices) const;
  void add_to(StateHash& hash) const;
  [[nodiscard]] const std::vector<GrabState>& all() const { return grabs_; }
  [[nodiscard]] bool empty() const { return grabs_.empty(); }

 private:
  friend struct Fields<GrabSet>;
  [[nodiscard]] std::vector<GrabState>::iterator find(const std::string& grab_id);

  std::vector<GrabState> grabs_;
};

}  // namespace kerf::sheet
