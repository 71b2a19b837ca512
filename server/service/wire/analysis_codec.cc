#include "server/service/wire/analysis_codec.h"

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "server/base/overloaded.h"
#include "server/service/wire/choices.h"
#include "server/service/wire/geometry_codec.h"
#include "server/service/wire/region_codec.h"
#include "server/service/wire/reply_codec.h"

namespace kerf::wire {
namespace {

using scene::Quantity;
using scene::Reduce;

constexpr std::array<std::pair<v1::Probe::Quantity, Quantity>, 13> kQuantities{{
    {v1::Probe::DISPLACEMENT, Quantity::kDisplacement},
    {v1::Probe::POSITION, Quantity::kPosition},
    {v1::Probe::VELOCITY, Quantity::kVelocity},
    {v1::Probe::REACTION, Quantity::kReaction},
    {v1::Probe::STRAIN, Quantity::kStrain},
    {v1::Probe::STRESS, Quantity::kStress},
    {v1::Probe::ENERGY, Quantity::kEnergy},
    {v1::Probe::MOMENTUM, Quantity::kMomentum},
    {v1::Probe::ANGULAR_MOMENTUM, Quantity::kAngularMomentum},
    {v1::Probe::CENTRE_OF_MASS, Quantity::kCentreOfMass},
    {v1::Probe::OPENING, Quantity::kOpening},
    {v1::Probe::EXTENT, Quantity::kExtent},
    {v1::Probe::INTERSECTIONS, Quantity::kIntersections},
}};

constexpr std::array<std::pair<v1::Probe::Reduce, Reduce>, 5> kReductions{{
    {v1::Probe::EACH, Reduce::kEach},
    {v1::Probe::MEAN, Reduce::kMean},
    {v1::Probe::SUM, Reduce::kSum},
    {v1::Probe::MIN, Reduce::kMin},
    {v1::Probe::MAX, Reduce::kMax},
}};

constexpr std::array<std::pair<v1::Probe::Recovery, scene::Recovery>, 2> kRecoveries{{
    {v1::Probe::OF_TRIANGLES, scene::Recovery::kMean},
    {v1::Probe::PATCH, scene::Recovery::kPatch},
}};

constexpr std::array<std::pair<v1::Probe::StressMeasure, scene::StressMeasure>, 2> kStressMeasures{{
    {v1::Probe::BIOT, scene::StressMeasure::kBiot},
    {v1::Probe::CAUCHY, scene::StressMeasure::kCauchy},
}};

template <typename Message, typename Value, std::size_t count>
std::optional<Value> find_value(const std::array<std::pair<Message, Value>, count>& table, Message message) {
  for (const auto& [from, to] : table) {
    if (from == message) return to;
  }
  return std::nullopt;
}

template <typename Message, typename Value, std::size_t count>
Message find_message(const std::array<std::pair<Message, Value>, count>& table, Value value) {
  for (const auto& [from, to] : table) {
    if (to == value) return from;
  }
  return table.front().first;
}

Result<scene::StaticAnalysis> decode_static(const v1::StaticAnalysis& message, const std::string& path) {
  scene::StaticAnalysis analysis;
  if (message.loads_size() > 0) {
    if (message.steps() != 0) {
      return invalid_argument("LOADS_TWICE", path + " has both loads and steps; leave one out", path + ".steps");
    }
    analysis.loads.assign(message.loads().begin(), message.loads().end());
  } else if (message.steps() != 0) {
    if (message.steps() < 1 || message.steps() > static_cast<int>(scene::kMaxLoadSteps)) {
      return invalid_argument("OUT_OF_RANGE",
                              path + ".steps is " + std::to_string(message.steps()) + "; must be in 1.." +
                                  std::to_string(scene::kMaxLoadSteps),
                              path + ".steps");
    }
    analysis.loads.clear();
    for (int i = 1; i <= message.steps(); ++i) analysis.loads.push_back(static_cast<double>(i) / message.steps());
  }
  if (message.tolerance() != 0.0) analysis.tolerance = message.tolerance();
  if (message.max_iterations() != 0) analysis.max_iterations = message.max_iterations();
  return analysis;
}

void encode_static(const scene::StaticAnalysis& analysis, v1::StaticAnalysis& message) {
  message.mutable_loads()->Assign(analysis.loads.begin(), analysis.loads.end());
  message.set_tolerance(analysis.tolerance);
  message.set_max_iterations(analysis.max_iterations);
}

scene::DynamicAnalysis decode_dynamic(const v1::DynamicAnalysis& message) {
  scene::DynamicAnalysis analysis;
  analysis.ticks = message.ticks();
  if (message.measure_every() != 0) analysis.measure_every = message.measure_every();
  return analysis;
}

Result<scene::Probe> decode_probe(const v1::Probe& message, const std::string& path) {
  scene::Probe probe;
  probe.name = message.name();
  const std::optional<Quantity> quantity = find_value(kQuantities, message.quantity());
  if (!quantity) return unknown_enum(path + ".quantity", static_cast<int>(message.quantity()));
  probe.quantity = *quantity;
  for (const v1::Vec2& point : message.points()) probe.points.push_back(decode_vector(point));
  if (message.has_region()) {
    KERF_TRY_ASSIGN(probe.region, decode_region(message.region(), path + ".region"));
  }
  if (message.reduce() == v1::Probe::REDUCE_UNSPECIFIED) {
    const Reduce of_region = *quantity == Quantity::kReaction ? Reduce::kSum : Reduce::kMean;
    probe.reduce = message.has_region() ? of_region : Reduce::kEach;
  } else {
    const std::optional<Reduce> reduce = find_value(kReductions, message.reduce());
    if (!reduce) return unknown_enum(path + ".reduce", static_cast<int>(message.reduce()));
    probe.reduce = *reduce;
  }
  if (message.has_side()) probe.side = decode_vector(message.side());
  KERF_TRY(decode_choice(kRecoveries, message.recovery(), path + ".recovery", probe.recovery));
  KERF_TRY(decode_choice(kStressMeasures, message.stress_measure(), path + ".stress_measure", probe.measure));
  return probe;
}

void encode_probe(const scene::Probe& probe, v1::Probe& message) {
  message.set_name(probe.name);
  message.set_quantity(find_message(kQuantities, probe.quantity));
  for (const Eigen::Vector2d& point : probe.points) encode_vector(point, *message.add_points());
  if (probe.region) encode_region(*probe.region, *message.mutable_region());
  message.set_reduce(find_message(kReductions, probe.reduce));
  if (probe.side) encode_vector(*probe.side, *message.mutable_side());
  if (scene::is_in_plane(probe.quantity)) message.set_recovery(encode_choice(kRecoveries, probe.recovery));
  if (probe.quantity == Quantity::kStress) message.set_stress_measure(encode_choice(kStressMeasures, probe.measure));
}

}  // namespace

Result<scene::Analysis> decode_analysis(const v1::Analysis& message) {
  if (message.has_static_()) {
    KERF_TRY_ASSIGN(scene::StaticAnalysis analysis, decode_static(message.static_(), "analysis.static"));
    return scene::Analysis(std::move(analysis));
  }
  if (!message.has_modes()) return scene::Analysis(decode_dynamic(message.dynamic()));
  scene::ModalAnalysis modes;
  if (message.modes().count() != 0) modes.count = message.modes().count();
  if (message.modes().has_about()) {
    KERF_TRY_ASSIGN(modes.about, decode_static(message.modes().about(), "analysis.modes.about"));
  }
  return scene::Analysis(std::move(modes));
}

Result<std::vector<scene::Probe>> decode_probes(const google::protobuf::RepeatedPtrField<v1::Probe>& messages) {
  std::vector<scene::Probe> probes;
  for (int i = 0; i < messages.size(); ++i) {
    KERF_TRY_ASSIGN(scene::Probe probe, decode_probe(messages[i], "probes[" + std::to_string(i) + "]"));
    probes.push_back(std::move(probe));
  }
  return probes;
}

v1::Table encode_table(const analysis::Table& table) {
  v1::Table message;
  message.set_name(table.name);
  for (const std::string& column : table.columns) message.add_columns(column);
  for (const std::vector<double>& row : table.rows) {
    message.add_rows()->mutable_values()->Assign(row.begin(), row.end());
  }
  return message;
}

v1::StaticResult encode_statics(const analysis::StaticStats& stats) {
  v1::StaticResult message;
  message.set_load(stats.load);
  message.set_converged(stats.converged);
  message.set_residual(stats.residual);
  message.set_newton_iterations(stats.iterations);
  message.set_solves(stats.solves);
  message.set_stable(stats.is_stable);
  message.set_reason(stats.reason);
  message.mutable_left_out()->Assign(stats.left_out.begin(), stats.left_out.end());
  return message;
}

v1::DynamicResult encode_dynamics(const analysis::DynamicStats& stats) {
  v1::DynamicResult message;
  message.set_ticks(stats.ticks);
  message.set_simulated_s(stats.simulated);
  encode_flags(stats.flagged_ticks, *message.mutable_flagged_ticks());
  return message;
}

Status decode_analysis(const v1::Scene& scene, scene::SheetConfig& config) {
  KERF_TRY_ASSIGN(scene::Analysis analysis, decode_analysis(scene.analysis()));
  if (scene.analysis().dynamic().ticks() != 0) {
    return invalid_argument("TICKS_TWICE", "analysis.dynamic.ticks is for AnalyzeSheet only; set ticks of the scene",
                            "analysis.dynamic.ticks");
  }
  config.analysis = std::move(analysis);
  KERF_TRY_ASSIGN(config.probes, decode_probes(scene.probes()));
  return Nothing{};
}

void encode_analysis(const scene::SheetConfig& config, v1::Scene& scene) {
  v1::Analysis& message = *scene.mutable_analysis();
  std::visit(
      Overloaded{
          [&message](const scene::DynamicAnalysis& in_time) {
            message.mutable_dynamic()->set_measure_every(in_time.measure_every);
          },
          [&message](const scene::StaticAnalysis& of_loads) { encode_static(of_loads, *message.mutable_static_()); },
          [&message](const scene::ModalAnalysis& modes) {
            message.mutable_modes()->set_count(modes.count);
            if (modes.about) encode_static(*modes.about, *message.mutable_modes()->mutable_about());
          },
      },
      config.analysis);
  for (const scene::Probe& probe : config.probes) encode_probe(probe, *scene.add_probes());
}

}  // namespace kerf::wire
