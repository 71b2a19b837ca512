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

namespace kerf::sheet {

// Distributes a sheet's loads over its vertices, triangles and edges; follows its cuts. Without loads it does nothing.
class AppliedForces {
 public:
  // Errors: kInvalidArgument UNKNOWN_VERTEX, POINT_OUTSIDE, NOTHING_LOADED. The last is for a load on borders whose
  // region has no border edge, unless cuts are scheduled, which may bring one. It is also for a load on triangles whose
  // region has none.
  static Result<AppliedForces> create(std::shared_ptr<const SheetConfig> config, const BuiltMesh& initial);

  [[nodiscard]] bool empty() const { return shares_.empty(); }
  // Returns true if any load changes with time. last_change(): the time (s) after which none does; -infinity if none
  // ever does.
  [[nodiscard]] bool varies() const { return last_change() > -kForever; }
  [[nodiscard]] double last_change() const;

  // Follows cuts, or the undo of some: regions and points are looked up again. A load without a place left stops
  // acting; a force on a vertex that is gone acts where the vertex was.
  void follow(const mesh::TriangleMesh& mesh, const BuiltMesh& initial);

  // Overwrites the external forces, pressure and edge moments of `loads`. `model`: of the mesh, with the clamps in
  // force.
  void set(const Instant& now, const mesh::TriangleMesh& mesh, const fem::Model& model, fem::Loads& loads) const;

 private:
  struct Share {
    mesh::VertexId vertex = mesh::kNone;
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, at factor 1
  };
  struct EdgeShare {
    mesh::TriangleId slot = mesh::kNone;
    int edge = 0;         // opposite that corner
    double moment = 0.0;  // N m per m, at factor 1
  };
  // The shares of one load.
  struct Shares {
    std::vector<Share> forces;
    std::vector<mesh::TriangleId> pressed;  // slots
    std::vector<EdgeShare> moments;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();  // m, of a PointForce, where it acts
  };

  explicit AppliedForces(std::shared_ptr<const SheetConfig> config) : config_(std::move(config)) {}

  std::shared_ptr<const SheetConfig> config_;
  static void follow(const PointForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);
  static void follow(const EdgeForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);
  static void follow(const AreaForce& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);
  static void follow(const Pressure& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);
  static void follow(const EdgeMoment& load, const mesh::TriangleMesh& mesh, const BuiltMesh& initial, Shares& shares);

  std::vector<Shares> shares_;  // of each load
};

}  // namespace kerf::sheet
