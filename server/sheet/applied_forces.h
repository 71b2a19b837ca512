#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/mesh/triangle_mesh.h"
#include "server/mesh/vertex_field.h"
#include "server/sheet/held_vertices.h"
#include "server/sheet/sheet_config.h"

namespace kerf::sheet {

// The dead forces of a sheet's loads on its vertices; follows its cuts. Without loads it does nothing.
class AppliedForces {
 public:
  // Errors: kInvalidArgument UNKNOWN_VERTEX, POINT_OUTSIDE; NOTHING_LOADED: a region has no border edge, and no cut
  // that may bring one is scheduled, or it has no triangle.
  static Result<AppliedForces> create(std::shared_ptr<const SheetConfig> config, const mesh::TriangleMesh& mesh);

  [[nodiscard]] bool empty() const { return shares_.empty(); }
  // Whether anything changes with time, and the time after which nothing does; -infinity: none.
  [[nodiscard]] bool varies() const { return last_change() > -kForever; }
  [[nodiscard]] double last_change() const;

  // After cuts, or after some were taken back: regions and points are looked up again. What has no place any more acts
  // no more; a force on a vertex that goes acts where that was.
  void follow(const mesh::TriangleMesh& mesh);

  // Overwrites `forces` (3 x V, N).
  void set(const Instant& now, const mesh::TriangleMesh& mesh, mesh::VertexField& forces) const;

 private:
  struct Share {
    mesh::VertexId vertex = mesh::kNone;
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, at factor 1
  };

  explicit AppliedForces(std::shared_ptr<const SheetConfig> config) : config_(std::move(config)) {}

  std::shared_ptr<const SheetConfig> config_;
  std::vector<std::vector<Share>> shares_;  // of each load
  std::vector<Eigen::Vector2d> places_;     // m, of each load: of a PointForce, where it acts
};

}  // namespace kerf::sheet
