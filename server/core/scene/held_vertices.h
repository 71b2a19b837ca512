#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/loads.h"
#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/mesh_source.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::sheet {

inline constexpr double kForever = std::numeric_limits<double>::infinity();

// Argument at which histories are read: a time, or in a static analysis a load.
struct Instant {
  double time = 0.0;    // s, or load
  double absent = 1.0;  // -, the factor of a condition without history: 1, or the load
};

// The vertices that a sheet's constraints hold, and where; follows its cuts. Without constraints it does nothing.
class HeldVertices {
 public:
  // Errors: kInvalidArgument UNKNOWN_VERTEX; REGION_EMPTY: a region names no vertex, and no cut that may bring
  // some is scheduled; NOT_PLANAR.
  static Result<HeldVertices> create(std::shared_ptr<const SheetConfig> config, const BuiltMesh& initial);

  [[nodiscard]] bool empty() const { return groups_.empty() && !plane_; }
  [[nodiscard]] bool has_slopes() const;
  // Returns true if any constraint changes with time. last_change(): the time (s) after which none does; -infinity if
  // none ever does.
  [[nodiscard]] bool varies() const { return last_change_ > -kForever; }
  [[nodiscard]] double last_change() const { return last_change_; }

  // Follows cuts, or the undo of some (without edits then). Regions are looked up again; copies that a cut makes of a
  // listed vertex count as listed.
  void follow(const mesh::TriangleMesh& mesh, std::span<const mesh::MeshEdit* const> edits, const BuiltMesh& initial);

  // Fills `held`, sorted by vertex, with the `pins` (whole, sorted) and over them the components held at `end`, dt (s)
  // after `begin`. dt 0: at once, without velocity.
  void set(std::span<const fem::Pin> pins, const Instant& begin, const Instant& end, double dt,
           const mesh::TriangleMesh& mesh, std::vector<fem::Pin>& held) const;

  // Slopes held at `now`, sorted by vertex.
  [[nodiscard]] std::vector<fem::Clamp> clamps(const Instant& now) const;

 private:
  struct Start {
    mesh::VertexId vertex = mesh::kNone;
    Eigen::Vector2d material = Eigen::Vector2d::Zero();                          // m
    Eigen::Vector3d displacement = Eigen::Vector3d::Zero();                      // m, at factor 1
    Eigen::Vector3d x = Eigen::Vector3d::Zero();                                 // m, where its material point started
    Eigen::Matrix<double, 3, 2> gradient = Eigen::Matrix<double, 3, 2>::Zero();  // -, of x by material there
  };
  using Group = std::vector<Start>;  // of one constraint, sorted by vertex

  explicit HeldVertices(std::shared_ptr<const SheetConfig> config) : config_(std::move(config)) {}
  [[nodiscard]] const std::vector<Constraint>& constraints() const { return config_->constraints; }
  static void place(const Constraint& constraint, const BuiltMesh& initial, Start& start);
  static void inherit(const mesh::MeshEdit& edit, Group& group);

  struct Plane {
    int component = 2;  // of the world
    double at = 0.0;    // m
  };

  std::shared_ptr<const SheetConfig> config_;
  std::vector<Group> groups_;  // one a constraint
  std::optional<Plane> plane_;
  double last_change_ = -kForever;
};

}  // namespace kerf::sheet
