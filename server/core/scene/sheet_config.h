#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/base/result.h"
#include "server/core/contact/collider.h"
#include "server/core/cut/curve.h"
#include "server/core/fem/element/material.h"
#include "server/core/linear/linear_solver_kind.h"
#include "server/core/mesh/ids.h"
#include "server/core/scene/command.h"
#include "server/core/scene/conditions.h"

// All input needed to start one sheet and to run it again, bit for bit: kerf.v1.Scene without Protocol Buffers. SI
// units throughout; right-handed world, +z up. Nothing changes a SheetConfig after Sheet::create.
namespace kerf::scene {

// Limits of a scene (see server/request-limits.md).
using mesh::kMaxMeshFileBytes;
using mesh::kMaxVertices;
using mesh::RestShape;
inline constexpr std::size_t kMaxOutlineHoles = 1024;  // most curves of holes
inline constexpr std::size_t kMaxOutlineSizes = 1024;
inline constexpr std::size_t kMaxOutlineChords = 1'000'000;  // most chords of all curves of an outline, after
                                                             // flattening
inline constexpr std::size_t kMaxReadObjects = 64;           // names in MeshReading::objects
inline constexpr std::size_t kMaxSheetIdBytes = 63;
inline constexpr std::size_t kMaxComponents = 64;
inline constexpr std::size_t kMaxColliders = 64;
inline constexpr std::size_t kMaxScheduledCommands = 10'000;

// Says what to do if a sheet is too stiff for real time: kExact computes it as it is, kRealTime softens the membrane
// (see fem::choose_softening).
enum class Fidelity { kExact, kRealTime };

enum class GridPattern { kUniformDiagonals, kJitteredDelaunay };

// A rectangle from (0, 0) to (width, height) in material coordinates. Vertex ids are row-major: id = j * columns + i.
struct GridSource {
  std::int32_t columns = 50;  // vertices along x, 2..1000
  std::int32_t rows = 50;     // vertices along y, 2..1000; columns * rows <= kMaxVertices
  double width = 1.0;         // m, > 0, <= 1e4
  double height = 1.0;        // m, > 0, <= 1e4
  GridPattern pattern = GridPattern::kUniformDiagonals;
  std::uint32_t seed = 0;  // seed of the jitter, for kJitteredDelaunay
};

// Wavefront OBJ; see core/mesh/build/obj_import.h. The positions in the text place the sheet; Placement is ignored.
struct ObjSource {
  std::string text;  // at most kMaxMeshFileBytes
  mesh::MeshReading reading = {};
};

// PLY, text or binary; see core/mesh/build/ply_import.h. The positions in the file place the sheet; Placement is
// ignored.
struct PlySource {
  std::string data;  // at most kMaxMeshFileBytes
  mesh::MeshReading reading = {};
};

// A mesh given by its arrays.
struct ArraySource {
  Eigen::Matrix2Xd material_positions;  // 2 x V, m; or 2 x 0 if there are rest_positions: then they are computed
  Eigen::Matrix3Xi triangles;           // 3 x T, vertex ids in 0..V-1
  Eigen::Matrix3Xd positions;           // 3 x V, m, start in the world; or 3 x 0: rest_positions, or without these the
                                        // Placement
  Eigen::Matrix3Xd rest_positions;      // 3 x V, m, the rest shape in space; or 3 x 0 if it is flat

  [[nodiscard]] Eigen::Index num_vertices() const {
    return rest_positions.cols() > 0 ? rest_positions.cols() : material_positions.cols();
  }
};

// The edge length wanted near a place: edge_length + growth * (distance from the place).
struct OutlineSizing {
  std::variant<Eigen::Vector2d, cut::Curve> place = Eigen::Vector2d(0.0, 0.0);  // m; a point, or a whole curve
  double edge_length = 0.0;                                                     // m, 1e-9..1e4
  double growth = 0.25;                                                         // -, 0.01..10
};

// A flat sheet of any outline; see core/mesh/build/outline_mesh.h.
struct OutlineSource {
  cut::Curve boundary;               // the border: closed lines, of panels and of holes in them
  std::vector<cut::Curve> holes;     // each of one or more closed lines; at most kMaxOutlineHoles
  double edge_length = 0.0;          // m, largest edge length, 1e-9..1e4; 0: 1/32 of the border's larger side
  std::vector<OutlineSizing> sizes;  // at most kMaxOutlineSizes
  double min_angle_deg = 25.0;       // degrees, 5..28
};

using MeshSource = std::variant<GridSource, ObjSource, PlySource, ArraySource, OutlineSource>;

// Start position in the world of material point (x, y): origin + x * x_axis + y * y_axis.
struct Placement {
  Eigen::Vector3d origin{0.0, 0.0, 0.0};  // m
  Eigen::Vector3d x_axis{1.0, 0.0, 0.0};  // -, unit (1e-6)
  Eigen::Vector3d y_axis{0.0, 0.0, 1.0};  // -, unit (1e-6), perpendicular to x_axis (1e-6)
};

// A part of a scene with a mesh of its own, in coordinates of its own. The material plane of the scene holds all
// components side by side.
struct Component {
  std::string name;  // [a-z][a-z0-9-]{0,62}, unique in the scene
  MeshSource mesh;
  std::optional<Placement> placement;     // of own coordinates; absent: upright, beside others as in the plane
  std::optional<Eigen::Vector2d> offset;  // m, place of the own origin in the plane; absent: on the right of all before
};

// Place of a component in the sheet as built.
struct ComponentPlace {
  std::string name;
  Eigen::Vector2d offset{0.0, 0.0};  // m, own coordinates plus this are in the scene's material plane
  Eigen::AlignedBox2d extent;        // m, bounding box in own coordinates
  Eigen::AlignedBox2d room;          // m, in the scene's plane: the box, enlarged so that no other component meets it
  mesh::VertexId first_vertex = 0;
  std::int32_t num_vertices = 0;
};

// A command that the scene itself gives. It takes effect at the start of the step from tick - 1 to tick, before
// commands from outside.
struct ScheduledCommand {
  std::int64_t tick = 1;  // >= 1
  Command command;
};

// A part of the sheet with another material.
struct RegionMaterial {
  Region region;  // see find_triangles
  fem::Material material;
  std::string given_as = {};  // field of the scene that has it, for errors; empty: its entry of Scene.materials
};

// The integrator of a sheet.
enum class IntegratorKind {
  kAutomatic,         // see fem::AutomaticIntegrator
  kExplicitLeapfrog,  // explicit, with as many substeps per tick as stability requires
  kImplicitEuler,     // Newton iterations; first order, strongly damped
  kTrapezoidal,       // Newton iterations; second order, damps nothing
  kBdf2,              // Newton iterations; second order, damps unresolved frequencies
  kTrBdf2,            // Newton iterations; second order, damps unresolved frequencies
};
// Versions of how kAutomatic chooses. Recordings and stores name the one that stepped their sheet, so that it is
// stepped again with every bit. The first takes implicit Euler for very stiff sheets: see fem::AutomaticIntegrator.
inline constexpr std::int32_t kFirstChoice = 1;
inline constexpr std::int32_t kNewestChoice = 2;
using linear::EigenvalueNorm;
using linear::LinearSolverKind;
enum class Precision { kDouble, kMixed };  // of explicit steps, see fem::Precision

struct IntegratorSettings {
  IntegratorKind kind = IntegratorKind::kAutomatic;
  std::int32_t max_substeps = 20000;   // explicit: most substeps per tick, 1..100000
  std::int32_t newton_iterations = 2;  // implicit: most iterations per solve, 1..100
  double solver_tolerance = 1.0e-4;    // implicit: relative residual of the linear solver, 1e-14..0.1; if below 1e-4,
                                       // also that of Newton's method
  LinearSolverKind solver = LinearSolverKind::kBlockJacobiCg;  // implicit; kind kAutomatic chooses the solver itself
  std::int32_t max_linear_iterations = 1000;                   // implicit: most iterations of a solve by conjugate
                                                               // gradients, 1..100000
  linear::CovarianceRootOptions covariance_root{};             // power 0.01..2, newton_schulz_iterations 1..50
  double highest_mode_damping = 0.05;                          // explicit: -, 0..0.5, see fem::IntegratorOptions
  Precision precision = Precision::kMixed;
  std::int32_t choice = kNewestChoice;  // of kAutomatic: version of how it chooses, kFirstChoice..kNewestChoice
};

// Analyses and measurements that a request may have: kerf.v1.Analysis and Probe. They have no effect on a running
// sheet.
inline constexpr std::size_t kMaxProbes = 64;
inline constexpr std::size_t kMaxProbeNameBytes = 63;
inline constexpr std::size_t kMaxProbePoints = 1024;
inline constexpr std::size_t kMaxLoadSteps = 10'000;
inline constexpr double kMinResidual = 1.0e-13;
inline constexpr double kMaxResidual = 0.1;
inline constexpr std::int32_t kMaxStaticIterations = 100'000;
inline constexpr std::int32_t kMaxModes = 200;
inline constexpr std::int64_t kMaxAnalyzedTicks = 100'000;
inline constexpr std::int32_t kMaxMeasureEvery = 10'000'000;

// Steps the sheet in time.
struct DynamicAnalysis {
  std::int64_t ticks = 0;          // ticks to step, 0..kMaxAnalyzedTicks; 0: none, or in a scene SheetConfig::ticks
  std::int32_t measure_every = 1;  // ticks from one measurement to the next, 1..kMaxMeasureEvery; the start and the end
                                   // are always measured
};

// Finds equilibria under a load that grows from 0 to 1; histories take it as their time.
struct StaticAnalysis {
  std::vector<double> loads{1.0};     // -, loads at which to find an equilibrium, in (0, 1], ascending
  double tolerance = 1.0e-9;          // -, kMinResidual..kMaxResidual; see fem::EquilibriumStats::residual
  std::int32_t max_iterations = 300;  // most Newton steps per load, 1..kMaxStaticIterations
};

// Finds the vibrations of lowest frequency about a state.
struct ModalAnalysis {
  std::int32_t count = 10;              // number of modes, 1..kMaxModes
  std::optional<StaticAnalysis> about;  // the state is the last equilibrium of this; absent: the state at the start of
                                        // the scene, after the commands of tick 1
};

using Analysis = std::variant<DynamicAnalysis, StaticAnalysis, ModalAnalysis>;

enum class Quantity {
  kDisplacement,     // m, x y z
  kPosition,         // m, x y z
  kVelocity,         // m/s, x y z
  kReaction,         // N, force that pins and constraints exert, x y z
  kStrain,           // -, xx yy xy in material coordinates, co-rotational; xy: half the shear angle
  kStress,           // Pa, xx yy xy of the stress that Probe::measure selects
  kEnergy,           // J, kinetic, membrane, bending, gravity, total
  kMomentum,         // kg m/s, x y z
  kAngularMomentum,  // kg m^2/s, x y z about the centre of mass
  kCentreOfMass,     // m, x y z
  kOpening,          // m, distance of a cut's lips: normal, sliding, lateral
  kExtent,           // m, size of the bounding box in the world, x y z
  kIntersections,    // number of pairs of triangles that pass through each other
};

enum class Reduce { kEach, kMean, kSum, kMin, kMax };

// Way to find strain or stress at a vertex from the triangles; see fem::Recovery.
enum class Recovery {
  kMean,   // mean of the triangles around it
  kPatch,  // superconvergent patch recovery
};

// Definition of stress; see fem::MembraneField.
enum class StressMeasure {
  kBiot,    // force per undeformed area
  kCauchy,  // force per deformed area
};

// A measurement that an analysis makes again and again, at ticks or loads. See kerf.v1.Probe.
struct Probe {
  std::string name;  // [a-z][a-z0-9_]{0,62}, unique
  Quantity quantity = Quantity::kDisplacement;
  std::vector<Eigen::Vector2d> points;  // m, material coordinates; at most kMaxProbePoints
  std::optional<Region> region;
  Reduce reduce = Reduce::kEach;
  std::optional<Eigen::Vector2d> side;           // m, material coordinates: measures on that side of a cut on which
                                                 // this point lies
  Recovery recovery = Recovery::kMean;           // for strain and stress; with kMean, a point that is no vertex takes
                                                 // the value of its triangle
  StressMeasure measure = StressMeasure::kBiot;  // for kStress
};

struct SheetConfig {
  std::string sheet_id;  // name for users: [a-z][a-z0-9-]{0,62} or empty; no effect on the simulation
  MeshSource mesh;
  std::vector<Component> components;  // at most kMaxComponents; if there are any, they replace `mesh` and `placement`
  fem::Material material;
  std::vector<RegionMaterial> materials;  // at most kMaxRegions; each replaces `material`, and earlier ones, in its
                                          // region
  fem::MembraneLaw membrane_law = fem::MembraneLaw::kCorotational;  // law of all materials
  Fidelity fidelity = Fidelity::kExact;                             // for steps in time; static and modal analyses are
                                                                    // always exact
  Placement placement;
  std::vector<Region> pins;                  // at most kMaxRegions
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  // m/s^2, |.| <= 1e4
  Wind wind;                                 // default: no air
  std::vector<contact::Collider> colliders;  // at most kMaxColliders
  SelfContact self_contact;
  double tick_rate_hz = 60.0;  // 1..1000; a tick is 1 / tick_rate_hz seconds
  IntegratorSettings integrator;
  std::int32_t max_vertices = kMaxVertices;  // 3..kMaxVertices; a cut that would need more is refused
  std::vector<Constraint> constraints;       // at most kMaxConstraints; they replace pins of the same component
  std::vector<Load> loads;                   // at most kMaxLoads
  History gravity_history;                   // factor on gravity; without times 1
  bool planar = false;                       // the sheet stays in the plane it starts in, perpendicular to x, y or z,
                                             // without bending stiffness
  std::optional<InitialVelocity> initial_velocity;  // default: at rest
  std::vector<ScheduledCommand> commands;  // at most kMaxScheduledCommands; those of the same tick are done in the
                                           // given order
  std::int64_t ticks = 0;                  // number of ticks that `kerf run` makes: 0..1e7, 0 means 600; no effect on
                                           // the simulation
  bool rest_damping = true;                // true: a calm sheet is damped until it rests, see RestWatch
  std::int64_t repeat_after = 0;           // ticks after which the owner of the sheet resets it, 0..1e7; 0: never. See
                                           // kerf.v1.Scene.repeat_after_ticks
  Analysis analysis;                       // the analysis that `kerf run` makes; no effect on the simulation
  std::vector<Probe> probes;               // what the analysis measures; at most kMaxProbes
  std::string description;                 // for people; at most 1000 bytes; no effect on the simulation
};

// Returns true for strain and stress, which are constant in each triangle.
[[nodiscard]] bool is_in_plane(Quantity quantity);

// Check ranges; fields are named as in kerf.v1.Scene ("analysis.static.loads[2]", "probes[1].points[0].x").
Status validate(const MeshSource& source);
Status validate(const Analysis& analysis);
Status validate(const std::vector<Probe>& probes);

// Returns true if the scene schedules cuts, which may bring vertices and lips to a region that has none at the start.
bool schedules_cuts(const SheetConfig& config);

// Returns true if `id` matches [a-z][a-z0-9-]{0,62}.
bool is_valid_sheet_id(std::string_view id);

// Checks everything that can be checked without a mesh. Sheet::create() calls it and then checks the rest. Fields are
// named as in kerf.v1.Scene ("grid.columns", "colliders[2].sphere.radius_m", "commands[0].command.grab.target.x").
Status validate(const SheetConfig& config);

}  // namespace kerf::scene
