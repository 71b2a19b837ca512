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

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::scene {

inline constexpr double kForever = std::numeric_limits<double>::infinity();

// The argument of histories: a time, or the load of a static analysis.
struct Instant {
  double time = 0.0;    // s, or -, the load of a static analysis
  double absent = 1.0;  // -, the factor of a condition without history: 1, or the load
};

// The vertices that the constraints of a scene hold, and their prescribed positions; it follows cuts. Without
// constraints it does nothing.
class HeldVertices {
 public:
  // Errors: kInvalidArgument UNKNOWN_VERTEX, REGION_EMPTY, NOT_PLANAR (SheetConfig::planar). A region without vertices
  // is allowed if it is no list and cuts are scheduled, which may bring some.
  static Result<HeldVertices> create(std::shared_ptr<const SheetConfig> config, const BuiltMesh& initial);

  [[nodiscard]] bool empty() const { return groups_.empty() && !plane_; }
  [[nodiscard]] bool has_slopes() const;
  // Returns true if any constraint changes with time. last_change(): the time (s) after which no constraint changes;
  // -infinity if none ever changes.
  [[nodiscard]] bool varies() const { return last_change_ > -kForever; }
  [[nodiscard]] double last_change() const { return last_change_; }

  // Call after cuts, with their edits, and after undos, without edits. Finds regions on `mesh` again. Copies that a cut
  // makes of a listed vertex count as listed. `initial`: the sheet as built.
  void follow(const mesh::TriangleMesh& mesh, std::span<const mesh::MeshEdit* const> edits, const BuiltMesh& initial);

  // Fills `held`, sorted by vertex, with the pins, and with the components that constraints hold, which replace those
  // of pins. `pins`: sorted. Positions are those at `end`; velocities lead there from `begin`, dt (s) before. With dt =
  // 0 velocities are zero.
  void set(std::span<const fem::Pin> pins, const Instant& begin, const Instant& end, double dt,
           const mesh::TriangleMesh& mesh, std::vector<fem::Pin>& held) const;

  // Returns the slopes held at `now`, sorted by vertex.
  [[nodiscard]] std::vector<fem::Clamp> clamps(const Instant& now) const;

 private:
  friend struct Fields<HeldVertices>;
  struct Start {
    mesh::VertexId vertex = mesh::kNone;
    Eigen::Vector2d material = Eigen::Vector2d::Zero();                          // m
    Eigen::Vector3d displacement = Eigen::Vector3d::Zero();                      // m, when the factor is 1
    Eigen::Vector3d x = Eigen::Vector3d::Zero();                                 // m, its start position
    Eigen::Matrix<double, 3, 2> gradient = Eigen::Matrix<double, 3, 2>::Zero();  // -, of x by material
  };
  using Group = std::vector<Start>;  // the vertices that one constraint holds, sorted by vertex

  explicit HeldVertices(std::shared_ptr<const SheetConfig> config) : config_(std::move(config)) {}
  [[nodiscard]] const std::vector<Constraint>& constraints() const { return config_->constraints; }
  static void place(const Constraint& constraint, const BuiltMesh& initial, Start& start);
  static void inherit(const mesh::MeshEdit& edit, Group& group);

  struct Plane {
    int component = 2;  // component of world positions that is the same in the whole plane
    double at = 0.0;    // m, its value
  };

  std::shared_ptr<const SheetConfig> config_;
  std::vector<Group> groups_;  // one per constraint
  std::optional<Plane> plane_;
  double last_change_ = -kForever;
};

}  // namespace kerf::scene
