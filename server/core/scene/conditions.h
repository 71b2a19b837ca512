#pragma once

#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/cut/curve.h"
#include "server/core/mesh/ids.h"

// Regions of a sheet, the constraints that hold them and the loads on them: kerf.v1.Region, Constraint, Load and
// InitialVelocity without Protocol Buffers.
namespace kerf::scene {

inline constexpr std::size_t kMaxRegions = 64;                // most regions in one list
inline constexpr std::size_t kMaxListedVertices = 1'000'000;  // most ids in all vertex lists of one list of regions
                                                              // together
inline constexpr double kMaxMaterialCoordinate = 1.0e4;       // m, largest |component| of a point in material
                                                              // coordinates
inline constexpr double kMaxWorldCoordinate = 1.0e6;          // m, largest |component| of any vector in the world

// Vertices on an edge, or at corners, of the bounding box in material coordinates.
enum class RegionEdge {
  kTop,         // y = maximum
  kBottom,      // y = minimum
  kLeft,        // x = minimum
  kRight,       // x = maximum
  kCorners,     // the vertex nearest to each corner of the bounding box; of equally near ones the smallest id
  kTopCorners,  // the two of them at y = maximum
};

// A closed box in material coordinates.
struct MaterialBox {
  Eigen::Vector2d min{0.0, 0.0};  // m
  Eigen::Vector2d max{0.0, 0.0};  // m, each component >= that of min
};

// Everything within `within` of the segment from a to b, in material coordinates.
struct MaterialLine {
  // Side of the line, looking from a to b, on which the material lies. It tells the two lips of a cut along it apart.
  enum class Side { kBoth, kLeft, kRight };

  Eigen::Vector2d a{0.0, 0.0};  // m
  Eigen::Vector2d b{0.0, 0.0};  // m; may equal a
  double within = 0.0;          // m, 0..kMaxMaterialCoordinate; 0: kRegionTolerance times the size of the sheet
  Side side = Side::kBoth;
};

// Everything within `within` of a curve, in material coordinates.
struct MaterialCurve {
  cut::Curve curve;
  double within = 0.0;  // m, 0..kMaxMaterialCoordinate; 0: kCurveTolerance times the local edge length of the sheet as
                        // built
  MaterialLine::Side side = MaterialLine::Side::kBoth;  // looking along the curve
};

// The whole outer border or the whole border of one hole, whichever comes nearest to a material point.
struct NearestBorder {
  Eigen::Vector2d point{0.0, 0.0};  // m
};

// The vertex nearest to a material point; of equally near ones that with the smallest id.
struct NearestVertex {
  Eigen::Vector2d point{0.0, 0.0};  // m
};

struct WholeSheet {};

using RegionShape = std::variant<RegionEdge, MaterialBox, std::vector<mesh::VertexId>, MaterialLine, NearestVertex,
                                 WholeSheet, MaterialCurve, NearestBorder>;

// Selects vertices of the sheet, or of one component.
struct Region {
  Region() = default;
  template <typename Shape>
  requires(!std::same_as<Shape, Region> && std::constructible_from<RegionShape, Shape>)
      Region(Shape given, std::string of = {})  // NOLINT(google-explicit-constructor)
      : shape(std::move(given)), component(std::move(of)) {}

  RegionShape shape;      // m, in the scene's material plane, or in the component's own coordinates
  std::string component;  // name; empty: the whole sheet. Edges, corners and numbers of vertices are the component's
};

// Distance within which a vertex counts as on an edge or line.
inline constexpr double kRegionTolerance = 1.0e-9;  // -, over the larger side of the bounding box in material
                                                    // coordinates
// Distance within which a vertex counts as on a curve. Lips are within 0.02 edge lengths of their curve, unless the cut
// allows more.
inline constexpr double kCurveTolerance = 0.05;  // -, over the local edge length

inline constexpr std::size_t kMaxConstraints = 64;
inline constexpr std::size_t kMaxLoads = 64;
inline constexpr std::size_t kMaxHistoryPoints = 4096;
inline constexpr double kMaxHistoryTime = 1.0e7;    // s, or -, the load of a static analysis
inline constexpr double kMaxHistoryFactor = 1.0e6;  // -
inline constexpr double kMaxAngle = 1.0e4;          // rad
inline constexpr double kMaxForce = 1.0e12;         // N, N/m or Pa, largest |component|
inline constexpr double kMaxFactorSlope = 1.0e6;    // 1/m, largest |component| of LinearFactor::slope
inline constexpr double kMaxSpeed = 1.0e6;          // m/s and rad/s, largest |component|

// Unit of time below: seconds since the scene began; in a static analysis the load, which grows from 0 to 1.

// A factor over time: linear between the given times, constant before the first and after the last.
struct History {
  std::vector<double> times;    // s, or -, loads of a static analysis; ascending
  std::vector<double> factors;  // as many as times

  // Returns the factor at a time, or `absent` if there are no times.
  [[nodiscard]] double at(double time, double absent) const;
};

struct Rotation {
  Eigen::Vector3d axis{0.0, 0.0, 1.0};    // -, any length > 0
  Eigen::Vector3d centre{0.0, 0.0, 0.0};  // m
  double angle = 0.0;                     // rad, when the factor is 1
};

// Holds components of vertices on prescribed paths: c + R(f angle) (x0 - c) + f (displacement + stretch X). Here x0 is
// the start position of the vertex and X its material coordinates; f is the factor of `history`, default 1. c and R are
// centre and matrix of `rotation`. A component that several constraints hold follows the last of them.
struct Constraint {
  Region region;
  std::array<bool, 3> held{true, true, true};                                 // which of x, y, z of the world are held
  Eigen::Vector3d displacement{0.0, 0.0, 0.0};                                // m
  Eigen::Matrix<double, 3, 2> stretch = Eigen::Matrix<double, 3, 2>::Zero();  // -
  Eigen::Matrix3Xd displacements = Eigen::Matrix3Xd::Zero(3, 0);              // m, one per listed vertex, in place of
                                                                              // `displacement`; or 3 x 0
  std::optional<Rotation> rotation;
  History history;
  std::optional<double> until;  // time at which the constraint ends
  bool slope = false;           // also holds the slope across border edges, turned by `rotation`
};

struct PointForce {
  std::variant<mesh::VertexId, Eigen::Vector2d> point;  // an existing vertex, or a material point of the sheet (m)
  Eigen::Vector3d force{0.0, 0.0, 0.0};                 // N
};

// A factor on an edge force that varies along the edge: slope . (X - zero) at material point X.
struct LinearFactor {
  Eigen::Vector2d zero{0.0, 0.0};   // m
  Eigen::Vector2d slope{0.0, 0.0};  // 1/m, not zero; |component| <= kMaxFactorSlope

  [[nodiscard]] double at(const Eigen::Vector2d& material) const { return slope.dot(material - zero); }
};

// A force along border edges and lips with both ends in the region, per undeformed length. It is even unless there is a
// factor.
struct EdgeForce {
  Region region;
  Eigen::Vector3d force{0.0, 0.0, 0.0};  // N, total for factor 1 everywhere, or N/m
  bool is_total = true;
  std::optional<double> normal = {};  // N/m, instead of `force`: along the outward normal of the sheet as placed
  std::optional<LinearFactor> factor = {};
};

// A force on the triangles with all corners in the region, even per undeformed area.
struct AreaForce {
  Region region;
  Eigen::Vector3d force{0.0, 0.0, 0.0};  // N, total, or Pa
  bool is_total = true;
};

// A pressure along the present normals of the triangles with all corners in the region.
struct Pressure {
  Region region;
  double pressure = 0.0;  // Pa
};

// A moment about border edges with both ends in the region, which turns with these edges: see fem::EdgeMoment.
struct EdgeMoment {
  Region region;
  double moment = 0.0;  // N m, total, or N m per m
  bool is_total = true;
};

// A load with its history. Forces keep their direction when the sheet moves; pressure and moments follow it.
struct Load {
  std::variant<PointForce, EdgeForce, AreaForce, Pressure, EdgeMoment> kind;
  History history;
};

// Initial velocity of the sheet: linear + angular x (x - centre) for a vertex at x.
struct InitialVelocity {
  Eigen::Vector3d linear{0.0, 0.0, 0.0};   // m/s
  Eigen::Vector3d angular{0.0, 0.0, 0.0};  // rad/s
  std::optional<Eigen::Vector3d> centre;   // m; absent: the centre of mass of the sheet
};

// Check ranges only; whether listed vertices exist is checked when the sheet is known. `field`: the path of the list
// ("pins"), or of the region.
Status validate(const std::vector<Region>& regions, const std::string& field);
Status validate(const Region& region, const std::string& field);

// Check ranges only. Fields are named as in kerf.v1.Scene ("constraints[1].region.line.a.x",
// "loads[0].edge.force_n.x").
Status validate(const History& history, const std::string& field);
Status validate(const std::vector<Constraint>& constraints);
Status validate(const std::vector<Load>& loads);
Status validate(const InitialVelocity& velocity);

}  // namespace kerf::scene
