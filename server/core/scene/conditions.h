#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/mesh/ids.h"

// Regions of a sheet, and what holds and pushes them: kerf.v1.Region, Constraint, Load and InitialVelocity without
// Protocol Buffers.
namespace kerf::sheet {

inline constexpr std::size_t kMaxRegions = 64;                // in one list
inline constexpr std::size_t kMaxListedVertices = 1'000'000;  // in all vertex lists of one list of regions together
inline constexpr double kMaxMaterialCoordinate = 1.0e4;       // m
inline constexpr double kMaxWorldCoordinate = 1.0e6;          // m, a component of any world vector

// Edges of the material bounding box.
enum class RegionEdge {
  kTop,         // y = maximum
  kBottom,      // y = minimum
  kLeft,        // x = minimum
  kRight,       // x = maximum
  kCorners,     // the vertex nearest to each corner of the bounding box; the smallest id of several
  kTopCorners,  // of those, the two at y = maximum
};

// Closed box in material coordinates.
struct MaterialBox {
  Eigen::Vector2d min{0.0, 0.0};  // m
  Eigen::Vector2d max{0.0, 0.0};  // m, each >= min's
};

// All closer to the segment from a to b than `within`, in material coordinates.
struct MaterialLine {
  enum class Side { kBoth, kLeft, kRight };  // of the two lips of a cut along the line, looking from a to b

  Eigen::Vector2d a{0.0, 0.0};  // m
  Eigen::Vector2d b{0.0, 0.0};  // m; may be a
  double within = 0.0;          // m, 0..kMaxMaterialCoordinate; 0: kRegionTolerance of the sheet's size
  Side side = Side::kBoth;
};

// All closer to a curve than `within`, in material coordinates.
struct MaterialCurve {
  cut::Curve curve;
  double within = 0.0;  // m, 0..kMaxMaterialCoordinate; 0: kCurveTolerance of the sheet's edge length there, as built
  MaterialLine::Side side = MaterialLine::Side::kBoth;  // looking along the curve
};

// The whole border around the hole, or around the outside, that comes nearest to a material point.
struct NearestBorder {
  Eigen::Vector2d point{0.0, 0.0};  // m
};

// The one vertex that is nearest to a material point; of several the smallest id.
struct NearestVertex {
  Eigen::Vector2d point{0.0, 0.0};  // m
};

struct WholeSheet {};

// Vertices of the sheet.
using Region = std::variant<RegionEdge, MaterialBox, std::vector<mesh::VertexId>, MaterialLine, NearestVertex,
                            WholeSheet, MaterialCurve, NearestBorder>;

// A vertex counts as on an edge or a line within this.
inline constexpr double kRegionTolerance = 1.0e-9;  // -, of the larger side of the material bounding box
// A vertex counts as on a curve within this. Lips keep to their curve within 0.02, unless a cut allows more.
inline constexpr double kCurveTolerance = 0.05;  // -, of the edge length there

inline constexpr std::size_t kMaxConstraints = 64;
inline constexpr std::size_t kMaxLoads = 64;
inline constexpr std::size_t kMaxHistoryPoints = 4096;
inline constexpr double kMaxHistoryTime = 1.0e7;    // s, or load
inline constexpr double kMaxHistoryFactor = 1.0e6;  // -
inline constexpr double kMaxAngle = 1.0e4;          // rad
inline constexpr double kMaxForce = 1.0e12;         // N, N/m or Pa, a component
inline constexpr double kMaxFactorSlope = 1.0e6;    // 1/m
inline constexpr double kMaxSpeed = 1.0e6;          // m/s, rad/s

// Unit of time below: seconds since the sheet was made; in a static analysis the load, which grows from 0 to 1.

// A factor over time: straight between the given times, constant before the first and after the last.
struct History {
  std::vector<double> times;    // ascending
  std::vector<double> factors;  // as many

  // `absent`: the factor where there are no times.
  [[nodiscard]] double at(double time, double absent) const;
};

struct Rotation {
  Eigen::Vector3d axis{0.0, 0.0, 1.0};    // not zero
  Eigen::Vector3d centre{0.0, 0.0, 0.0};  // m
  double angle = 0.0;                     // rad, at factor 1
};

// Holds components of vertices on prescribed paths: c + R(f angle) (x0 - c) + f (displacement + stretch X), x0 where
// the vertex started, X its material point, f the factor. A component that several constraints hold follows the last of
// them.
struct Constraint {
  Region region;
  std::array<bool, 3> held{true, true, true};                                 // x, y, z of the world
  Eigen::Vector3d displacement{0.0, 0.0, 0.0};                                // m
  Eigen::Matrix<double, 3, 2> stretch = Eigen::Matrix<double, 3, 2>::Zero();  // -
  Eigen::Matrix3Xd displacements = Eigen::Matrix3Xd::Zero(3, 0);              // m, one a listed vertex, or 3 x 0
  std::optional<Rotation> rotation;
  History history;
  std::optional<double> until;  // time from which nothing is held any more
  bool slope = false;           // holds the slope across border edges, too; turns with the rotation
};

struct PointForce {
  std::variant<mesh::VertexId, Eigen::Vector2d> point;  // an existing vertex, or a material point of the sheet (m)
  Eigen::Vector3d force{0.0, 0.0, 0.0};                 // N
};

// Factor on an edge force at material point X: slope . (X - zero).
struct LinearFactor {
  Eigen::Vector2d zero{0.0, 0.0};   // m
  Eigen::Vector2d slope{0.0, 0.0};  // 1/m, not zero; |.| <= kMaxFactorSlope each

  [[nodiscard]] double at(const Eigen::Vector2d& material) const { return slope.dot(material - zero); }
};

// Along undeformed border edges, lips among them, both ends of which are in the region; evenly without a factor.
struct EdgeForce {
  Region region;
  Eigen::Vector3d force{0.0, 0.0, 0.0};  // N in all where the factor is 1, or N/m
  bool is_total = true;
  std::optional<double> normal = {};  // N/m, in place of the force: along the outward normal as placed
  std::optional<LinearFactor> factor = {};
};

// Evenly over undeformed triangles all corners of which are in the region.
struct AreaForce {
  Region region;
  Eigen::Vector3d force{0.0, 0.0, 0.0};  // N in all, or Pa
  bool is_total = true;
};

// Along the normals of triangles all corners of which are in the region, as they are now.
struct Pressure {
  Region region;
  double pressure = 0.0;  // Pa
};

// Bends the sheet about border edges both ends of which are in the region, and turns with them: see fem::EdgeMoment.
struct EdgeMoment {
  Region region;
  double moment = 0.0;  // N m in all, or N m per m
  bool is_total = true;
};

// The forces are dead: as given, whatever the sheet does.
struct Load {
  std::variant<PointForce, EdgeForce, AreaForce, Pressure, EdgeMoment> kind;
  History history;
};

// Initial velocity of a vertex at x: linear + angular x (x - centre).
struct InitialVelocity {
  Eigen::Vector3d linear{0.0, 0.0, 0.0};   // m/s
  Eigen::Vector3d angular{0.0, 0.0, 0.0};  // rad/s
  std::optional<Eigen::Vector3d> centre;   // m; absent: the centre of mass
};

// Check ranges only; the sheet checks that listed vertices exist. `field`: the path of the list ("pins"), or of the
// region.
Status validate(const std::vector<Region>& regions, const std::string& field);
Status validate(const Region& region, const std::string& field);

// Ranges only; fields are named as in kerf.v1.Scene ("constraints[1].region.line.a.x", "loads[0].edge.force_n.x").
Status validate(const History& history, const std::string& field);
Status validate(const std::vector<Constraint>& constraints);
Status validate(const std::vector<Load>& loads);
Status validate(const InitialVelocity& velocity);

}  // namespace kerf::sheet
