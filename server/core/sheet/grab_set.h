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

namespace kerf::sheet {

// The points of a sheet that users hold, in the order they were made; follows the sheet's cuts. A grab of a vertex
// stays with it while it has material. All others hold a material point, whichever vertices are around it.
class GrabSet {
 public:
  // `x`: 3 x V, m. `model`: of the mesh. dt: s. Errors: kAlreadyExists GRAB_EXISTS; kResourceExhausted TOO_MANY_GRABS;
  // kInvalidArgument UNKNOWN_VERTEX, POINT_OUTSIDE.
  Status add(const Grab& grab, const mesh::TriangleMesh& mesh, const fem::Model& model, const mesh::VertexField& x,
             double dt);
  // Move or end a grab. Error: kNotFound GRAB_NOT_FOUND.
  Status drag(const Drag& drag);
  Status release(const Release& release);
  void clear() { grabs_.clear(); }

  // Recomputes the default stiffness from the new material, for grabs that were given no stiffness of their own.
  void follow_material(const mesh::TriangleMesh& mesh, const fem::Model& model, double dt);
  // Moves grabs from vertices that an undo takes away to their ancestors, or to the material point where there are
  // none. Must be called before the mesh is reverted.
  void leave_new_vertices(const VertexAncestry& ancestry, const mesh::TriangleMesh& mesh);
  // Finds the held points in a mesh that was edited. A point without material moves to the nearest one with some.
  void follow(const mesh::TriangleMesh& mesh);

  // Overwrites `loads` with the springs of a step of dt (s), during which the targets move to where they are now.
  void set(const fem::Integrator& integrator, const fem::Model& model, double dt, std::vector<fem::Grab>& loads) const;
  // Makes the targets those from which the next step moves.
  void end_step();

  // Inserts the vertices that grabs hold into `vertices`, which stays sorted.
  void add_vertices_to(std::vector<mesh::VertexId>& vertices) const;
  void add_to(StateHash& hash) const;
  [[nodiscard]] const std::vector<GrabState>& all() const { return grabs_; }
  [[nodiscard]] bool empty() const { return grabs_.empty(); }

 private:
  [[nodiscard]] std::vector<GrabState>::iterator find(const std::string& grab_id);

  std::vector<GrabState> grabs_;
};

}  // namespace kerf::sheet
