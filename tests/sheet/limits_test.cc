// Limits of a scene at their edge: what is just within is accepted, and the next value, or one more, is refused with
// the field.
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using scenes::flat;

struct LimitedNumber {
  const char* field;  // as of the error
  double low;         // the least, and
  double high;        // the most there may be
  std::function<void(scene::SheetConfig& config, double value)> set;
};
struct LimitedCount {
  const char* field;
  int limit;  // the most
  std::function<void(scene::SheetConfig& config, int count)> set;
  const char* reason = "TOO_MANY";
};

const scene::Region kAll = scene::WholeSheet{};

scene::Constraint& constraint_of(scene::SheetConfig& config) {
  return config.constraints.emplace_back(hold(kAll));
}
// A load of that kind, with a history or without.
void load(scene::SheetConfig& config, const decltype(scene::Load::kind)& kind, const scene::History& history = {}) {
  config.loads = {{kind, history}};
}
// On the right edge, with that factor.
void load_by(scene::SheetConfig& config, const Vector2d& zero, const Vector2d& slope) {
  scene::EdgeForce edge{scene::RegionEdge::kRight, {1.0, 0.0, 0.0}, false};
  edge.factor = scene::LinearFactor{zero, slope};
  load(config, edge);
}

void expect_limits(const std::vector<LimitedNumber>& numbers) {
  for (const LimitedNumber& number : numbers) {
    const auto with = [&](double value) {
      scene::SheetConfig config = flat(4);
      number.set(config, value);
      return refused(config);
    };
    EXPECT_EQ(with(number.low), "made") << number.field;
    EXPECT_EQ(with(number.high), "made") << number.field;
    const std::string expected = std::string("OUT_OF_RANGE ") + number.field;
    EXPECT_EQ(with(std::nextafter(number.low, -kInfinity)), expected);
    EXPECT_EQ(with(std::nextafter(number.high, kInfinity)), expected);
  }
}

void expect_limits(const std::vector<LimitedCount>& counts) {
  for (const LimitedCount& count : counts) {
    const auto with = [&](int value) {
      scene::SheetConfig config = flat(4);
      count.set(config, value);
      return refused(config);
    };
    EXPECT_EQ(with(count.limit), "made") << count.field;
    EXPECT_EQ(with(count.limit + 1), std::string(count.reason) + " " + count.field);
  }
}

// In material coordinates.
TEST(Limits, OfRegions) {
  expect_limits({
      {"pins[0].line.within_m", 0.0, 1.0e4,
       [](scene::SheetConfig& c, double d) {
         c.pins = {scene::MaterialLine{{0.0, 0.0}, {1.0, 0.0}, d}};
       }},
      {"constraints[0].region.curve.within_m", 0.0, 1.0e4,
       [](scene::SheetConfig& c, double d) {
         c.constraints = {hold(scene::MaterialCurve{cut::Polyline{{{0.0, 0.0}, {1.0, 0.0}}}, d})};
       }},
      {"pins[0].line.a.x", -1.0e4, 1.0e4,
       [](scene::SheetConfig& c, double d) {
         c.pins = {scene::MaterialLine{{d, 0.0}, {0.0, 0.0}, 0.0}};
       }},
      {"pins[0].nearest.y", -1.0e4, 1.0e4,
       [](scene::SheetConfig& c, double d) {
         c.pins = {scene::NearestVertex{{0.0, d}}};
       }},
      {"loads[0].edge.region.border.x", -1.0e4, 1.0e4,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::EdgeForce{scene::NearestBorder{{d, 0.0}}, {1.0, 0.0, 0.0}, true});
       }},
  });
}

TEST(Limits, OfConstraints) {
  expect_limits({
      {"constraints[0].displacement_m.z", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) { constraint_of(c).displacement.z() = d; }},
      {"constraints[0].stretch_x.y", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) { constraint_of(c).stretch(1, 0) = d; }},
      {"constraints[0].stretch_y.x", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) { constraint_of(c).stretch(0, 1) = d; }},
      {"constraints[0].displacements_m[1].x", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         scene::Constraint& moved = c.constraints.emplace_back(hold(std::vector<mesh::VertexId>{3, 5}));
         moved.displacements = Eigen::Matrix3Xd::Zero(3, 2);
         moved.displacements(0, 1) = d;
       }},
      {"constraints[0].axis.x", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         constraint_of(c).rotation = scene::Rotation{{d, 0.0, 0.0}, {0.0, 0.0, 0.0}, 1.0};
       }},
      {"constraints[0].center.y", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         constraint_of(c).rotation = scene::Rotation{{0.0, 0.0, 1.0}, {0.0, d, 0.0}, 1.0};
       }},
      {"constraints[0].angle_rad", -1.0e4, 1.0e4,
       [](scene::SheetConfig& c, double d) {
         constraint_of(c).rotation = scene::Rotation{{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, d};
       }},
      {"constraints[0].until", -1.0e7, 1.0e7, [](scene::SheetConfig& c, double d) { constraint_of(c).until = d; }},
      {"constraints[0].history.times[0]", -1.0e7, 1.0e7,
       [](scene::SheetConfig& c, double d) {
         constraint_of(c).history = {{d}, {1.0}};
       }},
      {"constraints[0].history.factors[0]", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         constraint_of(c).history = {{0.0}, {d}};
       }},
  });
}

TEST(Limits, OfForces) {
  constexpr double kMost = 1.0e12;  // N, N/m, Pa, N m or N
  expect_limits({
      {"loads[0].point.force_n.x", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::PointForce{mesh::VertexId{5}, {d, 0.0, 0.0}});
       }},
      {"loads[0].edge.force_n.y", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::EdgeForce{scene::RegionEdge::kTop, {0.0, d, 0.0}, true});
       }},
      {"loads[0].edge.force_npm.z", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::EdgeForce{scene::RegionEdge::kTop, {0.0, 0.0, d}, false});
       }},
      {"loads[0].edge.normal_npm", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::EdgeForce{scene::RegionEdge::kTop, {0.0, 0.0, 0.0}, false, d});
       }},
      {"loads[0].area.force_n.x", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::AreaForce{kAll, {d, 0.0, 0.0}, true});
       }},
      {"loads[0].area.traction_pa.x", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::AreaForce{kAll, {d, 0.0, 0.0}, false});
       }},
      {"loads[0].pressure.pressure_pa", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::Pressure{kAll, d});
       }},
      {"loads[0].moment.moment_nm", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::EdgeMoment{scene::RegionEdge::kTop, d, true});
       }},
      {"loads[0].moment.moment_nm_per_m", -kMost, kMost,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::EdgeMoment{scene::RegionEdge::kTop, d, false});
       }},
      {"loads[0].edge.factor.zero.x", -1.0e4, 1.0e4,
       [](scene::SheetConfig& c, double d) {
         load_by(c, {d, 0.0}, {1.0, 1.0});
       }},
      {"loads[0].edge.factor.by_x", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         load_by(c, {0.0, 0.5}, {d, 1.0});
       }},
      {"loads[0].edge.factor.by_y", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         load_by(c, {0.5, 0.5}, {1.0, d});
       }},
      {"loads[0].history.times[0]", -1.0e7, 1.0e7,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::Pressure{kAll, 1.0}, {{d}, {1.0}});
       }},
      {"loads[0].history.factors[0]", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         load(c, scene::Pressure{kAll, 1.0}, {{0.0}, {d}});
       }},
      {"gravity_history.factors[0]", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         c.gravity_history = {{0.0}, {d}};
       }},
      {"initial_velocity.linear_mps.x", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         c.initial_velocity = scene::InitialVelocity{{d, 0.0, 0.0}, {0.0, 0.0, 0.0}, {}};
       }},
      {"initial_velocity.angular_radps.y", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         c.initial_velocity = scene::InitialVelocity{{0.0, 0.0, 0.0}, {0.0, d, 0.0}, {}};
       }},
      {"initial_velocity.center.z", -1.0e6, 1.0e6,
       [](scene::SheetConfig& c, double d) {
         c.initial_velocity = scene::InitialVelocity{{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, Vector3d(0.0, 0.0, d)};
       }},
  });
}

TEST(Limits, OfSettings) {
  expect_limits({
      {"tick_rate_hz", 1.0, 1000.0, [](scene::SheetConfig& c, double d) { c.tick_rate_hz = d; }},
      {"integrator.solver_tolerance", 1.0e-14, 0.1,
       [](scene::SheetConfig& c, double d) { c.integrator.solver_tolerance = d; }},
      {"integrator.highest_mode_damping", 0.0, 0.5,
       [](scene::SheetConfig& c, double d) { c.integrator.highest_mode_damping = d; }},
      {"wind.air_density_kgpm3", 0.0, 100.0, [](scene::SheetConfig& c, double d) { c.wind.air_density = d; }},
      {"wind.drag_coefficient", 0.0, 10.0, [](scene::SheetConfig& c, double d) { c.wind.drag_coefficient = d; }},
      {"analysis.static.tolerance", 1.0e-13, 0.1,
       [](scene::SheetConfig& c, double d) {
         c.analysis = scene::StaticAnalysis{{1.0}, d};
       }},
  });
}

TEST(Limits, OfLists) {
  const auto history = [](int count) {
    scene::History made;
    for (int i = 0; i < count; ++i) {
      made.times.push_back(i);
      made.factors.push_back(1.0);
    }
    return made;
  };
  expect_limits({
      {"pins", 64,
       [](scene::SheetConfig& c, int n) { c.pins.resize(static_cast<std::size_t>(n), scene::RegionEdge::kTop); }},
      {"materials", 64,
       [](scene::SheetConfig& c, int n) {
         c.materials.resize(static_cast<std::size_t>(n), {kAll, c.material});
       }},
      {"colliders", 64,
       [](scene::SheetConfig& c, int n) {
         c.colliders.resize(static_cast<std::size_t>(n), {contact::Plane{{0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}}, 0.0});
       }},
      {"constraints", 64,
       [](scene::SheetConfig& c, int n) {
         c.constraints.resize(static_cast<std::size_t>(n), hold(scene::RegionEdge::kTop));
       }},
      {"loads", 64,
       [](scene::SheetConfig& c, int n) {
         c.loads.resize(static_cast<std::size_t>(n), {scene::Pressure{kAll, 1.0}, {}});
       }},
      {"probes", 64,
       [](scene::SheetConfig& c, int n) {
         c.probes.resize(static_cast<std::size_t>(n));
         for (int i = 0; i < n; ++i) {
           c.probes[static_cast<std::size_t>(i)].name = "e" + std::to_string(i);
           c.probes[static_cast<std::size_t>(i)].quantity = scene::Quantity::kEnergy;
         }
       }},
      {"probes[0].points", 1024,
       [](scene::SheetConfig& c, int n) {
         scene::Probe& probe = c.probes.emplace_back();
         probe.name = "x";
         probe.points.resize(static_cast<std::size_t>(n), Vector2d(0.5, 0.5));
       }},
      {"commands", 10'000,
       [](scene::SheetConfig& c, int n) {
         c.commands.resize(static_cast<std::size_t>(n), {1, scene::Reset{}});
       }},
      {"constraints[0].history.times", 4096,
       [&](scene::SheetConfig& c, int n) { constraint_of(c).history = history(n); }},
      {"loads[0].history.times", 4096,
       [&](scene::SheetConfig& c, int n) {
         load(c, scene::Pressure{kAll, 1.0}, history(n));
       }},
      {"gravity_history.times", 4096, [&](scene::SheetConfig& c, int n) { c.gravity_history = history(n); }},
      {"description", 1000,
       [](scene::SheetConfig& c, int n) { c.description.assign(static_cast<std::size_t>(n), 'a'); }},
      {"sheet_id", 63, [](scene::SheetConfig& c, int n) { c.sheet_id.assign(static_cast<std::size_t>(n), 'a'); },
       "SHEET_ID"},
      {"probes[0].name", 63,
       [](scene::SheetConfig& c, int n) {
         scene::Probe& probe = c.probes.emplace_back();
         probe.name.assign(static_cast<std::size_t>(n), 'a');
         probe.quantity = scene::Quantity::kEnergy;
       },
       "PROBE_NAME"},
      {"analysis.static.loads", 10'000,
       [](scene::SheetConfig& c, int n) {
         scene::StaticAnalysis analysis;
         analysis.loads.clear();
         for (int i = 1; i <= n; ++i) analysis.loads.push_back(static_cast<double>(i) / n);
         c.analysis = analysis;
       },
       "OUT_OF_RANGE"},
  });
}

TEST(Limits, OfNumbersThatCount) {
  const auto about = [](std::int32_t iterations) {
    scene::StaticAnalysis analysis;
    analysis.max_iterations = iterations;
    return analysis;
  };
  const char* const kReason = "OUT_OF_RANGE";
  expect_limits({
      {"integrator.max_substeps", 100'000, [](scene::SheetConfig& c, int n) { c.integrator.max_substeps = n; },
       kReason},
      {"integrator.newton_iterations", 100, [](scene::SheetConfig& c, int n) { c.integrator.newton_iterations = n; },
       kReason},
      {"integrator.max_linear_iterations", 100'000,
       [](scene::SheetConfig& c, int n) { c.integrator.max_linear_iterations = n; }, kReason},
      {"analysis.modes.count", 200,
       [](scene::SheetConfig& c, int n) {
         c.analysis = scene::ModalAnalysis{n, {}};
       },
       kReason},
      {"analysis.modes.about.max_iterations", 100'000,
       [&](scene::SheetConfig& c, int n) {
         c.analysis = scene::ModalAnalysis{1, about(n)};
       },
       kReason},
      {"analysis.static.max_iterations", 100'000, [&](scene::SheetConfig& c, int n) { c.analysis = about(n); },
       kReason},
      {"analysis.dynamic.ticks", 100'000,
       [](scene::SheetConfig& c, int n) {
         c.analysis = scene::DynamicAnalysis{n, 1};
       },
       kReason},
      {"analysis.dynamic.measure_every", 10'000'000,
       [](scene::SheetConfig& c, int n) {
         c.analysis = scene::DynamicAnalysis{0, n};
       },
       kReason},
      {"ticks", 10'000'000, [](scene::SheetConfig& c, int n) { c.ticks = n; }, kReason},
      {"max_vertices", 500'000, [](scene::SheetConfig& c, int n) { c.max_vertices = n; }, kReason},
  });
}

// Limits apply to one region, and to the regions of a list together; one vertex may be listed any number of times.
TEST(Limits, OfListedVertices) {
  const auto listed = [](int count) { return std::vector<mesh::VertexId>(static_cast<std::size_t>(count), 5); };
  constexpr int kMost = 1'000'000;
  expect_limits({
      {"pins[0].vertices.vertices", kMost, [&](scene::SheetConfig& c, int n) { c.pins = {listed(n)}; }},
      {"pins", kMost,
       [&](scene::SheetConfig& c, int n) {
         c.pins = {listed(kMost / 2), listed(n - kMost / 2)};
       }},
      {"constraints[0].region.vertices.vertices", kMost,
       [&](scene::SheetConfig& c, int n) { c.constraints = {hold(listed(n))}; }},
  });
  std::vector<mesh::VertexId> all;  // of a triangle at least, which a material needs
  for (int i = 0; i < kMost; ++i) all.push_back(i % 16);
  expect_limits({
      {"materials", kMost,
       [&](scene::SheetConfig& c, int n) {
         const std::vector<mesh::VertexId> rest(all.begin(), all.begin() + (n - kMost / 2));
         c.materials = {{std::vector<mesh::VertexId>(all.begin(), all.begin() + kMost / 2), c.material},
                        {rest, c.material}};
       }},
  });
}

}  // namespace
}  // namespace kerf::sheet
