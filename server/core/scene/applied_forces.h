#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/held_vertices.h"
#include "server/core/scene/mesh_source.h"
#include "server/core/scene/sheet_config.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::scene {

// Distributes the loads of a scene over the vertices, triangles and edges of its sheet, and follows cuts. Without loads
// it does nothing.
class AppliedForces {
 public:
  // Errors: kInvalidArgument UNKNOWN_VERTEX, POINT_OUTSIDE, NOTHING_LOADED. The last means that the region of a load on
  // triangles has no triangle, or that of a load on border edges no such edge. A region without border edges is allowed
  // if cuts are scheduled, which may bring some.
  static Result<AppliedForces> create(std::shared_ptr<const SheetConfig> config, const BuiltMesh& initial);

  [[nodiscard]] bool empty() const { return shares_.empty(); }
  // Returns true if any load changes with time. last_change(): the time (s) after which no load changes; -infinity if
  // none ever changes.
  [[nodiscard]] bool varies() const { return last_change() > -kForever; }
  [[nodiscard]] double last_change() const;

  // Call after cuts and undos: finds regions and points on `mesh` again. A load whose place no longer exists stops
  // acting. A force on a vertex that no longer exists acts at the material point where the vertex was. `initial`: the
  // sheet as built.
  void follow(const mesh::TriangleMesh& mesh, const BuiltMesh& initial);

  // Overwrites the external forces, pressure and edge moments of `loads` by those at `now`. `model`: that of `mesh`,
  // with the present clamps.
  void set(const Instant& now, const mesh::TriangleMesh& mesh, const fem::Model& model, fem::Loads& loads) const;

 private:
  friend struct Fields<AppliedForces>;
  struct Share {
    mesh::VertexId vertex = mesh::kNone;
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, when the factor of the load's history is 1
  };
  struct EdgeShare {
    mesh::TriangleId slot = mesh::kNone;
    int edge = 0;         // edge of the slot opposite this corner
    double moment = 0.0;  // N m per m, when the factor of the load's history is 1
  };
  // The parts of one load on vertices, triangles and edges.
  struct Shares {
    std::vector<Share> forces;
    std::vector<mesh::TriangleId> pressed;  // slots on which a Pressure acts
    std::vector<EdgeShare> moments;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();  // m, material coordinates where a PointForce acts
  };

  explicit AppliedForces(std::shared_ptr<const SheetConfig> config) : config_(std::move(config)) {}

  std::shared_ptr<const SheetConfig> config_;
  static void follow(const PointForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);
  static void follow(const EdgeForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);
  static void follow(const AreaForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);
  static void follow(const Pressure& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);
  static void follow(const EdgeMoment& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);

  std::vector<Shares> shares_;  // by index into SheetConfig::loads
};

}  // namespace kerf::scene
