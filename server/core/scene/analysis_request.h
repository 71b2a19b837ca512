#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/fem/statics/recovered_fields.h"
#include "server/core/scene/region.h"

// Requests for analyses and measurements of a scene: kerf.v1.Analysis and Probe without Protocol Buffers. They have no
// effect on a running sheet.
namespace kerf::sheet {

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

// Steps in time.
struct DynamicAnalysis {
  std::int64_t ticks = 0;          // 0..kMaxAnalyzedTicks; of a scene 0: SheetConfig::ticks
  std::int32_t measure_every = 1;  // ticks, 1..kMaxMeasureEvery; the start and the end are measured anyway
};

// Equilibria under a load that grows from 0 to 1.
struct StaticAnalysis {
  std::vector<double> loads{1.0};     // (0, 1], ascending
  double tolerance = 1.0e-9;          // -, kMinResidual..kMaxResidual; see fem::EquilibriumStats::residual
  std::int32_t max_iterations = 300;  // Newton steps a load, 1..kMaxStaticIterations
};

// The lowest vibrations about a state.
struct ModalAnalysis {
  std::int32_t count = 10;              // 1..kMaxModes
  std::optional<StaticAnalysis> about;  // its last equilibrium; absent: the state that the scene begins with, after the
                                        // commands of tick 1
};

using Analysis = std::variant<DynamicAnalysis, StaticAnalysis, ModalAnalysis>;

enum class Quantity {
  kDisplacement,     // m, x y z
  kPosition,         // m, x y z
  kVelocity,         // m/s, x y z
  kReaction,         // N, x y z
  kStrain,           // -, xx yy xy in material coordinates, co-rotational; xy: half the shear angle
  kStress,           // Pa, xx yy xy: of Probe::measure
  kEnergy,           // J, kinetic, membrane, bending, gravity, total
  kMomentum,         // kg m/s, x y z
  kAngularMomentum,  // kg m^2/s, x y z about the centre of mass
  kCentreOfMass,     // m, x y z
  kOpening,          // m, normal sliding lateral
  kExtent,           // m, x y z
};

enum class Reduce { kEach, kMean, kSum, kMin, kMax };

// Measure of stress; see fem::MembraneField.
enum class StressMeasure {
  kBiot,    // force by undeformed area
  kCauchy,  // force by area as it is
};

// A measurement made after each tick, or at each load. See kerf.v1.Probe.
struct Probe {
  std::string name;  // [a-z][a-z0-9_]{0,62}, unique
  Quantity quantity = Quantity::kDisplacement;
  std::vector<Eigen::Vector2d> points;  // m, material; at most kMaxProbePoints
  std::optional<Region> region;
  Reduce reduce = Reduce::kEach;
  std::optional<Eigen::Vector2d> side;            // m, material: of a cut, the side of this point
  fem::Recovery recovery = fem::Recovery::kMean;  // of strain and stress; kMean where a place is no vertex: triangles
  StressMeasure measure = StressMeasure::kBiot;   // of stress
};

// Strain or stress: constant in each triangle.
[[nodiscard]] bool is_in_plane(Quantity quantity);

// Fields are named as in kerf.v1.Scene ("analysis.static.loads[2]", "probes[1].points[0].x").
Status validate(const Analysis& analysis);
Status validate(const std::vector<Probe>& probes);

}  // namespace kerf::sheet
