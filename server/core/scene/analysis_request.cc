#include "server/core/scene/sheet_config.h"

#include <algorithm>
#include <set>

#include "server/base/overloaded.h"
#include "server/core/scene/field_checks.h"

namespace kerf::scene {

namespace {

bool is_valid_name(const std::string& name) {
  if (name.empty() || name.size() > kMaxProbeNameBytes || name[0] < 'a' || name[0] > 'z') return false;
  return std::all_of(name.begin(), name.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; });
}

Status validate(const StaticAnalysis& analysis, const std::string& path) {
  KERF_TRY(check_integer(static_cast<std::int64_t>(analysis.loads.size()), 1, static_cast<std::int64_t>(kMaxLoadSteps),
                         path + ".loads"));
  for (std::size_t i = 0; i < analysis.loads.size(); ++i) {
    const std::string field = path + ".loads[" + std::to_string(i) + "]";
    KERF_TRY(check_number(analysis.loads[i], 0.0, 1.0, field));
    if (analysis.loads[i] <= (i > 0 ? analysis.loads[i - 1] : 0.0)) {
      return invalid_argument("NOT_ASCENDING", field + " must be greater than 0 and than the previous load", field);
    }
  }
  KERF_TRY(check_number(analysis.tolerance, kMinResidual, kMaxResidual, path + ".tolerance"));
  return check_integer(analysis.max_iterations, 1, kMaxStaticIterations, path + ".max_iterations");
}

// Returns true if the quantity belongs to the whole sheet, not to a place.
bool is_global(Quantity quantity) {
  switch (quantity) {
    case Quantity::kEnergy:
    case Quantity::kMomentum:
    case Quantity::kAngularMomentum:
    case Quantity::kCentreOfMass:
    case Quantity::kExtent:
    case Quantity::kIntersections:
      return true;
    default:
      return false;
  }
}

Status validate_place(const Probe& probe, const std::string& path) {
  const bool has_points = !probe.points.empty();
  if (is_global(probe.quantity)) {
    if (!has_points && !probe.region) return Nothing{};
    return invalid_argument("PLACE_UNUSED", path + " measures the whole sheet; it takes no points and no region",
                            has_points ? path + ".points" : path + ".region");
  }
  if (has_points == probe.region.has_value()) {
    return invalid_argument("PLACE_MISSING", path + " needs either points or a region", path + ".points");
  }
  if (probe.quantity == Quantity::kReaction && has_points) {
    return invalid_argument("PLACE_MISSING",
                            path + " needs a region: it measures the reactions of the vertices held there",
                            path + ".region");
  }
  if (probe.quantity == Quantity::kOpening && !has_points) {
    return invalid_argument("PLACE_MISSING", path + " needs points on a cut", path + ".points");
  }
  if (probe.reduce == Reduce::kEach && !has_points) {
    return invalid_argument("REDUCE_MISSING", path + ".reduce must not be EACH for a region", path + ".reduce");
  }
  return Nothing{};
}

// Refuses choices that do not apply to the quantity of the probe.
Status validate_field(const Probe& probe, const std::string& path) {
  if (probe.recovery != Recovery::kMean && !is_in_plane(probe.quantity)) {
    return invalid_argument("RECOVERY_UNUSED", path + ".recovery applies to STRAIN and STRESS only; leave it out",
                            path + ".recovery");
  }
  if (probe.measure != StressMeasure::kBiot && probe.quantity != Quantity::kStress) {
    return invalid_argument("STRESS_MEASURE_UNUSED", path + ".stress_measure applies to STRESS only; leave it out",
                            path + ".stress_measure");
  }
  return Nothing{};
}

Status validate(const Probe& probe, const std::string& path) {
  if (!is_valid_name(probe.name)) {
    return invalid_argument("PROBE_NAME", path + ".name must match [a-z][a-z0-9_]{0,62}", path + ".name");
  }
  KERF_TRY(check_count(probe.points.size(), kMaxProbePoints, "points", path + ".points"));
  for (std::size_t i = 0; i < probe.points.size(); ++i) {
    const std::string field = path + ".points[" + std::to_string(i) + "]";
    KERF_TRY(check_vector(probe.points[i], kMaxMaterialCoordinate, field));
  }
  if (probe.region) {
    KERF_TRY(validate(*probe.region, path + ".region"));
  }
  if (probe.side) {
    KERF_TRY(check_vector(*probe.side, kMaxMaterialCoordinate, path + ".side"));
  }
  KERF_TRY(validate_field(probe, path));
  return validate_place(probe, path);
}

Status validate(const DynamicAnalysis& analysis) {
  KERF_TRY(check_integer(analysis.ticks, 0, kMaxAnalyzedTicks, "analysis.dynamic.ticks"));
  return check_integer(analysis.measure_every, 1, kMaxMeasureEvery, "analysis.dynamic.measure_every");
}

Status validate(const ModalAnalysis& modes) {
  KERF_TRY(check_integer(modes.count, 1, kMaxModes, "analysis.modes.count"));
  return modes.about ? validate(*modes.about, "analysis.modes.about") : Nothing{};
}

}  // namespace

bool is_in_plane(Quantity quantity) {
  return quantity == Quantity::kStrain || quantity == Quantity::kStress;
}

Status validate(const Analysis& analysis) {
  return std::visit(Overloaded{
                        [](const DynamicAnalysis& in_time) { return validate(in_time); },
                        [](const StaticAnalysis& of_loads) { return validate(of_loads, "analysis.static"); },
                        [](const ModalAnalysis& modes) { return validate(modes); },
                    },
                    analysis);
}

Status validate(const std::vector<Probe>& probes) {
  KERF_TRY(check_count(probes.size(), kMaxProbes, "probes", "probes"));
  std::set<std::string> names;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const std::string path = "probes[" + std::to_string(i) + "]";
    KERF_TRY(validate(probes[i], path));
    if (!names.insert(probes[i].name).second) {
      return invalid_argument("PROBE_TWICE", path + ".name is already the name of an earlier probe", path + ".name");
    }
  }
  return Nothing{};
}

}  // namespace kerf::scene
